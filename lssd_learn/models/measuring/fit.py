"""Lays a body that varies and bends on a scan: closest points, both ways, and steps of Gauss and Newton's."""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float, Int
from scipy.linalg import cho_factor, cho_solve
from scipy.spatial.transform import Rotation

from lssd_learn.kdtree import cKDTree
from lssd_learn.maps.matching.surface import on_faces
from lssd_learn.models.measuring.even import even
from lssd_learn.models.measuring.posable import Lying, Posable, Pose
from lssd_learn.shapes import Mesh, Shape
from lssd_learn.shapes.normals import normals
from lssd_learn.shapes.triangles import triangle_normals

NORMALS = 0.06  # metres that a unit normal weighs as much as, in matching
AROUND = 3  # vertices around which the closest triangle is looked for
MOST = 20000  # points of a scan that are looked at
DAMPED = 1e-6
TELLING = 300  # so many of the matches are taken to be independent
CAP, EXTRA = 0.03, 0.03  # metres: what is farther off counts as much; what is has no counterpart
MISSING = 0.04  # metres from which on there is nothing of a scan near a place of the body


@dataclass(frozen=True)
class Stage:
    """Some rounds.

    Attributes:
        rounds: how many.
        modes: that are free.
        points: of the scan, and as many of the body, that are matched.
        far: metres from which on a match counts half or less, in the first and the last round.
        back: how much the matches of the scan's points count; the others are of the body's.
        exact: whether the scan's points are matched with points of triangles, not with vertices.
        sure: metres that matches are off for other reasons than the body's: at least, and as seen where `seen`.
    """

    rounds: int
    modes: int
    points: int
    far: tuple[float, float]
    back: float
    sure: float
    exact: bool = False
    seen: bool = False


FIRST = Stage(8, 6, 300, (0.15, 0.08), 0.5, 0.03)
SECOND = Stage(15, 20, 800, (0.08, 0.03), 0.5, 0.01)
# The vertices of a scan lie on the surface, and its edges under it: in the end it is they that count.
THIRD = Stage(15, 99, 2000, (0.03, 0.01), 0.7, 0.0005, seen=True)
LAST = Stage(8, 99, 2000, (0.01, 0.006), 0.95, 0.0002, exact=True, seen=True)


@dataclass(frozen=True, eq=False)
class Scan:
    """What is known of a scan, in metres.

    Attributes:
        points: (N, 3) of it.
        normals: (N, 3) there, and oriented: whether their signs are known.
        surface: (M, 3) points all over it.
    """

    points: Float[np.ndarray, "N 3"]
    normals: Float[np.ndarray, "N 3"]
    oriented: bool
    surface: Float[np.ndarray, "M 3"]

    @classmethod
    def of(cls, shape: Shape, surface: Float[np.ndarray, "M 3"]) -> "Scan":
        """Of a mesh, whose faces all look outwards or all inwards, or of a cloud."""
        facing = normals(shape)
        if isinstance(shape, Mesh):
            corners = (shape.vertices - shape.vertices.mean(0))[shape.faces]
            if (corners.mean(1) * triangle_normals(corners)).sum() < 0:
                facing = -facing
        some = np.sort(even(shape, MOST, np.random.default_rng(0)))
        return cls(shape.points[some], facing[some], isinstance(shape, Mesh), surface)


@dataclass(frozen=True, eq=False)
class Fit:
    """A body on a scan.

    Attributes:
        pose: of it.
        lying: where it lies.
        off: metres, root mean square of how far points of the scan are from it, of which each counts 3 cm at most.
        missing: the part of it that has nothing of the scan near.
        extra: the part of the scan that has nothing of it near.
    """

    pose: Pose
    lying: Lying
    off: float
    missing: float
    extra: float


def settled(body: Posable, loose: Float[np.ndarray, " B"], scan: Scan, pose: Pose, stage: Stage) -> Pose:
    """A pose after the rounds of a stage.

    Args:
        loose: (B,) radians that joints are taken to turn, one standard deviation.
    """
    rng, count = np.random.default_rng(0), min(stage.modes, body.modes.shape[-1])
    some = np.sort(rng.permutation(len(body.mean))[: stage.points])
    theirs = np.sort(rng.permutation(len(scan.points))[: stage.points])
    weights = np.zeros(count)
    weights[: len(pose.weights)] = pose.weights[:count]
    pose = replace(pose, weights=weights)
    for far in np.geomspace(*stage.far, stage.rounds):
        pose = _step(body, loose, scan, pose, stage, float(far), some, theirs)
    return pose


def told(body: Posable, scan: Scan, pose: Pose, spread: Int[np.ndarray, " s"], points: int = 3000) -> Fit:
    """How well a body lies on a scan.

    Args:
        spread: vertices all over it.
        points: of the scan that are looked at.
    """
    lying = body.lying(pose)
    some = scan.points[np.sort(np.random.default_rng(1).permutation(len(scan.points))[:points])]
    at = _closest(body, lying.points, cKDTree(lying.points).query(some, AROUND)[1], some)[0]
    away = np.linalg.norm(at - some, axis=1)
    lost = cKDTree(scan.surface).query(lying.points[spread])[0] > MISSING
    off = float(np.sqrt(np.mean(np.minimum(away, CAP) ** 2)))
    return Fit(pose, lying, off, float(lost.mean()), float((away > EXTRA).mean()))


def _step(
    body: Posable,
    loose: Float[np.ndarray, " B"],
    scan: Scan,
    pose: Pose,
    stage: Stage,
    far: float,
    some: np.ndarray,
    theirs: np.ndarray,
) -> Pose:
    """A step of Gauss and Newton's towards planes of matched points, far ones of which count less (Geman, McClure)."""
    lying, k = body.lying(pose), len(pose.weights)
    facing = normals(Mesh(lying.points, body.faces)) if len(body.faces) else body.turned(lying)
    points, seen = scan.points[theirs], scan.normals[theirs]
    if not scan.oriented:  # outwards is where the nearest point of the body says it is
        nearest = cKDTree(lying.points).query(points)[1]
        seen = np.where(((facing[nearest] * seen).sum(1) < 0)[:, None], -seen, seen)
    marked = np.hstack([points, NORMALS * seen])
    found = cKDTree(np.hstack([lying.points, NORMALS * facing])).query(marked)[1]
    if stage.exact:
        around = np.column_stack([found, cKDTree(lying.points).query(points, AROUND)[1]])
        at, corners, shares = _closest(body, lying.points, around, points)
        planes = np.einsum("mc,mcx->mx", shares, facing[corners])
        planes /= np.maximum(np.linalg.norm(planes, axis=1, keepdims=True), 1e-9)
        rows = body.rows(lying, corners, shares, planes, k)
    else:
        at, planes = lying.points[found], facing[found]
        rows = body.rows(lying, found[:, None], np.ones((len(found), 1)), planes, k)
    parts = [(rows, *_weighed(points - at, planes, seen, far, stage.back))]
    if stage.back < 1:
        ours, mine = lying.points[some], facing[some]
        hit = cKDTree(marked).query(np.hstack([ours, NORMALS * mine]))[1]
        weighed = _weighed(points[hit] - ours, seen[hit], mine, far, 1 - stage.back)
        parts.append((body.rows(lying, some[:, None], np.ones((len(some), 1)), seen[hit], k), *weighed))
    left = np.sum([(rows * share[:, None]).T @ rows for rows, _, share in parts], axis=0)
    right = np.sum([rows.T @ (share * off) for rows, off, share in parts], axis=0)
    sure, (_, off, share) = stage.sure, parts[0]
    if stage.seen:
        sure = max(sure, float(np.sqrt((share * off**2).sum() / max(share.sum(), 1e-12))))
    turned = Rotation.from_matrix(pose.turns[1:]).as_rotvec().ravel()
    free = np.repeat(loose[1:], 3)
    prior = sure**2 / TELLING * np.concatenate([np.zeros(6), 1 / free**2, np.ones(k)])
    right = right - prior * np.concatenate([np.zeros(6), turned, pose.weights])
    left = left + np.diag(prior + DAMPED * np.diag(left) + 1e-12)
    return body.moved(pose, cho_solve(cho_factor(left, check_finite=False), right, check_finite=False))


def _weighed(
    away: np.ndarray, planes: np.ndarray, others: np.ndarray, far: float, whole: float
) -> tuple[np.ndarray, np.ndarray]:
    """(m,) distances along planes and (m,) shares of these, which are the smaller the less the normals agree."""
    squares, agree = (away**2).sum(axis=1), np.clip((planes * others).sum(axis=1), 0, 1)
    return (away * planes).sum(axis=1), agree * whole / len(away) / (1 + squares / far**2) ** 2


def _closest(
    body: Posable, lying: np.ndarray, around: np.ndarray, points: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(m, 3) the closest points of its triangles, (m, 3) their corners and (m, 3) shares."""
    found, shares = on_faces(body.faces, lying, around, points)
    corners = body.faces[found]
    return np.einsum("mc,mcx->mx", shares, lying[corners]), corners, shares
