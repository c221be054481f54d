"""Poses of one shape on another, bettered by the closest points of the two: many poses at once. Used by `rigid.py`."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from scipy.spatial.transform import Rotation

from lssd_learn.errors import InputError
from lssd_learn.kdtree import cKDTree
from lssd_learn.shapes.kabsch import kabsch
from lssd_learn.shapes.mesh import Mesh, Shape
from lssd_learn.shapes.normals import normals
from lssd_learn.shapes.sampling import spread

# Lengths are in parts of the root mean square distance of a shape's points from their mean, its size.
POINTS = 1000  # of each shape
NORMALS = 0.1  # weight of a unit normal against a distance
TRIMMED = 0.9  # share of the matches that count: what is farthest may have no counterpart
SETTLED = 1e-7  # change of a rotation below which it has settled
POLISHED = 10  # rounds, at most, of laying a shape on the planes of its matches
FLAT = 0.01  # mean of position times normal below which nothing says which way is out


@dataclass(frozen=True, eq=False)
class Sampled:
    """What alignment knows of a shape.

    Attributes:
        points: (N, 3) spread out over it, of mean 0 and size 1; some of the first are spread out too.
        normals: (N, 3).
        oriented: whether they all point outwards; those of a cloud are known up to their sign.
        centre: (3,) and size, in the shape's own units.
    """

    points: Float[np.ndarray, "N 3"]
    normals: Float[np.ndarray, "N 3"]
    oriented: bool
    centre: Float[np.ndarray, " 3"]
    size: float


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
class Poses:
    """S poses: y ≈ s x Q + t. Q (S, 3, 3), t (S, 3), s (S,), and side (S,), the determinant of Q."""

    Q: np.ndarray
    t: np.ndarray
    s: np.ndarray
    side: np.ndarray

    def some(self, chosen: np.ndarray) -> "Poses":
        return Poses(self.Q[chosen], self.t[chosen], self.s[chosen], self.side[chosen])


def angles(rotation: Float[np.ndarray, "*S 3 3"]) -> np.ndarray:
    """(…) degrees that orthogonal matrices (…, 3, 3) turn by; where they mirror, beside mirroring across the axis."""
    trace = np.trace(rotation, axis1=-2, axis2=-1)
    return np.degrees(np.arccos(np.clip((trace - np.sign(np.linalg.det(rotation))) / 2, -1, 1)))


class Search:
    """The closest points of two shapes, for many poses at once: those of x on y, and those of y on x."""

    def __init__(self, x: Sampled, y: Sampled, weight: float, count: int | None = None):
        self._x, self._y, self._weight = x.points[:count], y.points[:count], weight
        self._nx, self._ny = x.normals[:count], y.normals[:count]
        self._trees = [cKDTree(self._joined(p, n)) for p, n in ((self._x, self._nx), (self._y, self._ny))]

    def _joined(self, points: np.ndarray, facing: np.ndarray) -> np.ndarray:
        return np.concatenate([points, self._weight * facing], axis=-1) if self._weight else points

    def matches(self, p: Poses) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Distances (S, N + M) with the normals' share, in the units of y; the match of each x, and of each y."""
        s, t = p.s[:, None, None], p.t[:, None]
        ahead, there = self._trees[1].query(self._joined(s * (self._x @ p.Q) + t, self._nx @ p.Q))
        back_to = p.Q.transpose(0, 2, 1)
        back, here = self._trees[0].query(self._joined((self._y - t) @ back_to / s, self._ny @ back_to))
        return np.concatenate([ahead, back * p.s[:, None]], axis=1), there, here

    def rounds(self, p: Poses, count: int) -> Poses:
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
            p = Poses(Q, t, s, p.side)
            if change < SETTLED:
                break
        return p

    def polished(self, p: Poses) -> Poses:
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
            moved = Poses(p.Q @ turn, growth * p.t @ turn + step[3:6], growth * p.s, p.side)
            residual = self.residuals(moved)[0]
            if not residual < best:
                break
            p, best = moved, residual
        return p

    def best(self, p: Poses, count: int, apart: float) -> np.ndarray:
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

    def residuals(self, p: Poses) -> Float[np.ndarray, " S"]:
        """(S,) root mean square distances from the other surface, the farthest tenth cut."""
        return self.off(p)[0]

    def off(self, p: Poses) -> tuple[Float[np.ndarray, " S"], Float[np.ndarray, "S N"], Float[np.ndarray, "S M"]]:
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
