"""How one shape lies on another of its kind: the turn, the shift and the side that lay it there, whatever way both lie.

For shapes that differ little but in how they lie: bones, teeth, faces. A shape that bends at joints has no such turn,
which the residual tells. What `collections/aligned.py` lays a whole collection with.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from lssd_learn.errors import InputError
from lssd_learn.shapes.kabsch import kabsch
from lssd_learn.shapes.mesh import Mesh, Shape
from lssd_learn.shapes.normals import normals
from lssd_learn.shapes.sampling import spread

MIRROR = ("auto", "forbid", "allow")

# Lengths are in parts of the root mean square distance of a shape's points from their mean, its size.
POINTS, FEW = 1000, 200  # of each shape, and those of them that all the starts are tried with
NORMALS = 0.1  # weight of a unit normal against a distance
TRIMMED = 0.9  # share of the matches that count: what is farthest may have no counterpart
CLEAR = 1.15  # ratio of two extents from which their axes tell which is which
KEPT = (10, 3)  # poses a side that are followed further after the first rounds, and after the rest with few points
ROUNDS = (3, 6, 10)  # of matching: with all starts, with those kept, with all points
POLISHED = 10  # rounds, at most, of laying the best of each side on the planes of its matches
APART = 30.0  # degrees between poses that are not the same
SETTLED = 1e-7  # change of a rotation below which it has settled
NEAR = 0.12  # a point whose match is farther away has none
FLAT = 0.01  # mean of position times normal below which nothing says which way is out
TIE = 1.15  # ratio of two residuals below which neither is better
FLOOR = 0.005  # residual below which samples of one surface differ anyway


@dataclass(frozen=True, eq=False)
class Sampled:
    """What alignment knows of a shape.

    Attributes:
        points: (N, 3) spread out over it, of mean 0 and size 1; some of the first are spread out too.
        normals: (N, 3).
        oriented: whether they all point outwards; those of a cloud are known up to their sign.
        centre: (3,) and size, in the shape's own units.
    """

    points: np.ndarray
    normals: np.ndarray
    oriented: bool
    centre: np.ndarray
    size: float


@dataclass(frozen=True, eq=False)
class Rigid:
    """Where a source lies on a target: as `points @ rotation + shift`.

    Attributes:
        rotation: (3, 3) orthogonal, of determinant −1 where mirrored.
        shift: (3,) in the units of the target.
        scale: of the target over the source, as matched; not applied.
        residual: root mean square distance of the points of either shape from the other's surface there, the farthest
            tenth cut, in parts of the size.
        rival: the same of the best pose of this side that is turned by more than 30°; infinite where there is none.
        missing, extra: the share of the target's points that have no counterpart, and of the source's.
    """

    rotation: np.ndarray
    shift: np.ndarray
    scale: float
    residual: float
    rival: float
    missing: float
    extra: float

    @property
    def mirrored(self) -> bool:
        return bool(np.linalg.det(self.rotation) < 0)

    @property
    def angle(self) -> float:
        """See `angles`."""
        return float(angles(self.rotation))


@dataclass(frozen=True, eq=False)
class Laid:
    """The best of both sides.

    Attributes:
        best, other: poses; None where the other side was not allowed.
    """

    best: Rigid
    other: Rigid | None

    @property
    def ties(self) -> list[str]:
        """In words, what neither is better of: "side", "turn"."""
        near = TIE * max(self.best.residual, FLOOR)
        side = self.other is not None and self.other.residual < near
        return ["side"] * side + ["turn"] * (self.best.rival < near)


def angles(rotation: np.ndarray) -> np.ndarray:
    """(…) degrees that orthogonal matrices (…, 3, 3) turn by; where they mirror, beside mirroring across the axis."""
    trace = np.trace(rotation, axis1=-2, axis2=-1)
    return np.degrees(np.arccos(np.clip((trace - np.sign(np.linalg.det(rotation))) / 2, -1, 1)))


def rigid(source: Shape | Sampled, target: Shape | Sampled, mirror: str = "auto") -> Laid:
    """The turn and shift, never a scale, that lay `source` on `target`.

    All turns of the axes of the one onto those of the other are tried, and for shapes whose axes are not clear the 60
    of the icosahedron, on both sides. From each the points of either shape are matched with the nearest of the other,
    in position and normal, and the source laid on its matches, turn and turn about (Besl and McKay 1992; trimmed:
    Chetverikov et al. 2005). Poses that do worse are left behind, and more points join in.

    Args:
        source, target: shapes, or what `sampled` made of them.
        mirror: "auto" tries both sides and keeps to the source's own where they tie; "allow" takes the better, however
            little; "forbid" mirrors nothing.

    Raises:
        InputError: another value of `mirror`, a mesh without area.
    """
    if mirror not in MIRROR:
        raise InputError(f"mirror={mirror}: expected one of {', '.join(MIRROR)}")
    own, other = both_sides(source, target, mirror != "forbid")
    return Laid(other, own) if other is not None and is_better(other, own, mirror) else Laid(own, other)


def is_better(mirrored: Rigid, own: Rigid, mirror: str) -> bool:
    """Whether the mirrored side is: by more than chance where `mirror` is "auto"."""
    if mirror == "auto":
        return TIE * max(mirrored.residual, FLOOR) < own.residual
    return mirrored.residual < own.residual


def both_sides(source: Shape | Sampled, target: Shape | Sampled, mirrored: bool = True) -> tuple[Rigid, Rigid | None]:
    """The best pose that does not mirror, and the best that does where that is asked for; see `rigid`."""
    x, y = (shape if isinstance(shape, Sampled) else sampled(shape) for shape in (source, target))
    weight = NORMALS if x.oriented and y.oriented else 0.0
    search, few = _Search(x, y, weight), _Search(x, y, weight, FEW)
    poses = few.rounds(_starts(x, y, (1, -1) if mirrored else (1,)), ROUNDS[0])
    poses = few.rounds(poses.some(few.best(poses, KEPT[0], 0.0)), ROUNDS[1])
    poses = search.rounds(poses.some(few.best(poses, KEPT[1], APART)), ROUNDS[2])
    residuals = search.residuals(poses)

    def best(side: int) -> Rigid:
        own = np.flatnonzero(poses.side == side)
        own = own[np.argsort(residuals[own], kind="stable")]
        found = search.polished(poses.some(own[:1]))
        turned = angles(found.Q[0].T @ poses.Q[own])
        return search.told(found, min(residuals[own][turned > APART], default=np.inf))

    return best(1), best(-1) if mirrored else None


def sampled(shape: Shape, seed: int = 0) -> Sampled:
    """What alignment knows of a shape; of a cloud of few points all of them.

    Raises:
        InputError: a mesh without area, or points that are all one.
    """
    mesh = isinstance(shape, Mesh)
    count = POINTS if mesh else min(POINTS, len(shape.vertices))
    W = spread(shape, count, np.random.default_rng(seed))
    points, facing = W @ shape.vertices, W @ normals(shape)
    lengths = np.linalg.norm(facing, axis=1, keepdims=True)
    facing = facing / np.where(lengths > 0, lengths, 1)
    centre = points.mean(axis=0)
    points = points - centre
    size = float(np.sqrt(np.square(points).sum(axis=1).mean()))
    if not size > 0:
        raise InputError("shape: expected points apart from one another, got a single place")
    points = points / size
    outwards = np.einsum("nx,nx->n", points, facing).mean()
    if mesh and outwards < -FLAT:  # a mesh that is inside out
        facing = -facing
    return Sampled(points, facing, mesh, centre, size)


@dataclass(frozen=True, eq=False)
class _Poses:
    """S poses: y ≈ s x Q + t. Q (S, 3, 3), t (S, 3), s (S,), and side (S,), the determinant of Q."""

    Q: np.ndarray
    t: np.ndarray
    s: np.ndarray
    side: np.ndarray

    def some(self, chosen: np.ndarray) -> "_Poses":
        return _Poses(self.Q[chosen], self.t[chosen], self.s[chosen], self.side[chosen])


def _starts(x: Sampled, y: Sampled, sides: tuple[int, ...]) -> _Poses:
    (axes_x, clear_x), (axes_y, clear_y) = _axes(x.points), _axes(y.points)
    turns = Rotation.create_group("O").as_matrix()
    if not (clear_x and clear_y):
        turns = np.concatenate([turns, Rotation.create_group("I").as_matrix()])
    Q = np.concatenate([side * axes_x @ turns @ axes_y.T for side in sides])
    return _Poses(Q, np.zeros((len(Q), 3)), np.ones(len(Q)), np.repeat(sides, len(turns)))


def _axes(points: np.ndarray) -> tuple[np.ndarray, bool]:
    """Principal axes as the columns of a rotation, and whether the extents tell one from another."""
    squares, axes = np.linalg.eigh(points.T @ points)
    axes[:, 0] *= np.sign(np.linalg.det(axes))
    extents = np.sqrt(np.maximum(squares, 0))
    return axes, all(b > CLEAR * a for a, b in pairwise(extents))


class _Search:
    """The closest points of two shapes, for many poses at once: those of x on y, and those of y on x."""

    def __init__(self, x: Sampled, y: Sampled, weight: float, count: int | None = None):
        self._x, self._y, self._weight, self._shapes = x.points[:count], y.points[:count], weight, (x, y)
        self._nx, self._ny = x.normals[:count], y.normals[:count]
        self._trees = [cKDTree(self._joined(p, n)) for p, n in ((self._x, self._nx), (self._y, self._ny))]

    def _joined(self, points: np.ndarray, facing: np.ndarray) -> np.ndarray:
        return np.concatenate([points, self._weight * facing], axis=-1) if self._weight else points

    def matches(self, p: _Poses) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Distances (S, N + M) with the normals' share, in the units of y; the match of each x, and of each y."""
        s, t = p.s[:, None, None], p.t[:, None]
        ahead, there = self._trees[1].query(self._joined(s * (self._x @ p.Q) + t, self._nx @ p.Q))
        back_to = p.Q.transpose(0, 2, 1)
        back, here = self._trees[0].query(self._joined((self._y - t) @ back_to / s, self._ny @ back_to))
        return np.concatenate([ahead, back * p.s[:, None]], axis=1), there, here

    def rounds(self, p: _Poses, count: int) -> _Poses:
        for _ in range(count):
            distances, there, here = self.matches(p)
            W = (distances <= np.quantile(distances, TRIMMED, axis=1, keepdims=True)).astype(float)
            W /= W.sum(axis=1, keepdims=True)
            A = np.concatenate([np.broadcast_to(self._x, (len(p.Q), *self._x.shape)), self._x[here]], axis=1)
            B = np.concatenate([self._y[there], np.broadcast_to(self._y, (len(p.Q), *self._y.shape))], axis=1)
            a, b = (np.einsum("sn,snx->sx", W, C)[:, None] for C in (A, B))
            A, B = A - a, B - b
            Q = p.side[:, None, None] * kabsch(p.side[:, None, None] * A, B, W)
            # Of both directions alike: the least squares of one would shrink what it moves.
            s = np.sqrt(np.einsum("sn,snx,snx->s", W, B, B) / np.einsum("sn,snx,snx->s", W, A, A))
            t = b[:, 0] - s[:, None] * (a @ Q)[:, 0]
            change = np.abs(Q - p.Q).max()
            p = _Poses(Q, t, s, p.side)
            if change < SETTLED:
                break
        return p

    def polished(self, p: _Poses) -> _Poses:
        """One pose moved so that points come near to the planes of their matches, as long as that betters it.

        Where points lie in a surface is chance: planes, unlike points, do not hold on to it (Chen and Medioni 1992).
        """
        best = self.residuals(p)[0]
        for _ in range(POLISHED):
            _, there, here = self.matches(p)
            ahead, back = (p.s[0] * x @ p.Q[0] + p.t[0] for x in (self._x, self._x[here[0]]))
            at, goals = np.concatenate([ahead, back]), np.concatenate([self._y[there[0]], self._y])
            facing = np.concatenate([self._ny[there[0]], self._nx[here[0]] @ p.Q[0]])
            off = np.einsum("nx,nx->n", goals - at, facing)
            kept = np.abs(off) <= np.quantile(np.abs(off), TRIMMED)
            A = np.hstack([np.cross(at, facing), facing, np.einsum("nx,nx->n", at, facing)[:, None]])[kept]
            # A surface of revolution can turn in itself: there the shortest solution does not move.
            step = np.linalg.lstsq(A, off[kept], rcond=0.01)[0]
            turn, growth = Rotation.from_rotvec(step[:3]).as_matrix().T, 1 + step[6]
            moved = _Poses(p.Q @ turn, growth * p.t @ turn + step[3:6], growth * p.s, p.side)
            residual = self.residuals(moved)[0]
            if not residual < best:
                break
            p, best = moved, residual
        return p

    def best(self, p: _Poses, count: int, apart: float) -> np.ndarray:
        """So many poses of each side, the best first, each turned by more than `apart` degrees from those before."""
        distances = self.matches(p)[0]
        worth = np.minimum(distances, np.quantile(distances, TRIMMED, axis=1, keepdims=True))
        chosen: list[int] = []
        order = np.argsort(np.square(worth).mean(axis=1), kind="stable")
        for side in dict.fromkeys(p.side.tolist()):
            kept: list[int] = []
            for i in order[p.side[order] == side]:
                if len(kept) < count and all(angles(p.Q[i].T @ p.Q[j]) > apart for j in kept if apart):
                    kept.append(int(i))
            chosen += kept
        return np.array(chosen)

    def residuals(self, p: _Poses) -> np.ndarray:
        """(S,) see `Rigid`."""
        return self._off(p)[0]

    def _off(self, p: _Poses) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Residuals (S,), and how far the match is of each x (S, N) and of each y (S, M), in sizes of y."""
        _, there, here = self.matches(p)
        ahead = p.s[:, None, None] * (self._x @ p.Q) + p.t[:, None] - self._y[there]
        back = p.s[:, None, None] * (self._x[here] @ p.Q) + p.t[:, None] - self._y
        off = np.abs(np.concatenate([
            np.einsum("snx,snx->sn", ahead, self._ny[there]),
            np.einsum("snx,snx->sn", back, self._nx[here] @ p.Q),
        ], axis=1))  # fmt: skip
        off = np.minimum(off, np.quantile(off, TRIMMED, axis=1, keepdims=True))
        return np.sqrt(np.square(off).mean(axis=1)), *(np.linalg.norm(v, axis=-1) for v in (ahead, back))

    def told(self, p: _Poses, rival: float) -> Rigid:
        """One pose in the units of the shapes."""
        residual, ahead, back = (values[0] for values in self._off(p))
        (x, y), Q = self._shapes, p.Q[0]
        shift = y.centre + y.size * p.t[0] - x.centre @ Q
        scale = float(p.s[0] * y.size / x.size)
        extra, missing = (float(np.mean(away > NEAR)) for away in (ahead, back))
        return Rigid(Q, shift, scale, float(residual), float(rival), missing, extra)
