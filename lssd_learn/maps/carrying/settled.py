"""Third step of carrying: a patch settles where its own form fits, near to where all hubs together say that it lies.

A map is right to a few percent; what tells where exactly a landmark belongs, a tip or a ridge, is the form around it.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from scipy.spatial.transform import Rotation

from lssd_learn.kdtree import cKDTree
from lssd_learn.maps.carrying.patches import Laid
from lssd_learn.shapes import Mesh
from lssd_learn.shapes.normals import normals

RADIUS = 0.04  # of a patch, over √area
MOST = 120  # vertices of one
PASSES = 2  # each from where the patches of all hubs have settled, on the average
ROUNDS = 6
NORMALS = 0.054  # weight of a unit normal against a distance, over √area, where points are matched
ALONG = 0.05  # weight of the way to the matched point, against that to its plane
HOLD = 0.01  # of the way back to where it lay
STIFF = 0.5  # of turning


@dataclass(frozen=True, eq=False)
class Patches:
    """The surface around L points of a mesh.

    Attributes:
        offsets: (L, K, 3) from the points, over √area.
        facing: (L, K, 3) unit normals.
        weights: (L, K) of sum 1, 0 where there are fewer than K vertices.
    """

    offsets: Float[np.ndarray, "L K 3"]
    facing: Float[np.ndarray, "L K 3"]
    weights: Float[np.ndarray, "L K"]


def patches(points: Float[np.ndarray, "L 3"], mesh: Mesh, radius: float = RADIUS) -> Patches:
    """Around points near a mesh: vertices within a radius over √area, of many some at random."""
    size = np.sqrt(mesh.area)
    around = cKDTree(mesh.vertices).query_ball_point(points, radius * size)
    outward, rng = normals(mesh), np.random.default_rng(0)
    offsets, facing = np.zeros((len(points), MOST, 3)), np.zeros((len(points), MOST, 3))
    weights = np.zeros((len(points), MOST))
    for number, (point, found) in enumerate(zip(points, around, strict=True)):
        some = rng.permutation(np.sort(found).astype(int))[:MOST]
        count = len(some)
        offsets[number, :count] = (mesh.vertices[some] - point) / size
        facing[number, :count] = outward[some]
        weights[number, :count] = np.exp(-2 * np.square(offsets[number, :count] / radius).sum(axis=1))
    return Patches(offsets, facing, weights / np.maximum(weights.sum(axis=1, keepdims=True), np.finfo(float).tiny))


class Surface:
    """A mesh that patches settle on."""

    def __init__(self, mesh: Mesh):
        self.size, self.facing = float(np.sqrt(mesh.area)), normals(mesh)
        self.points = mesh.vertices / self.size
        self._tree = cKDTree(np.hstack([self.points, NORMALS * self.facing]))

    def settled(self, own: Patches, lying: Laid, start: Float[np.ndarray, "L 3"]) -> Float[np.ndarray, "L 3"]:
        """Where L points end up whose patches begin at `start`, turned as they were laid.

        In each round the vertices of a patch are matched with the nearest here, in position and normal, and the patch
        is moved and turned a little towards their planes; the farther it has come, the more it is held back.

        Args:
            own: the patches of the points on their own shape.
            lying: how the map turns them.
            start: places here; NaN stays where it is.

        Reference:
            Planes of the matched points after Chen and Medioni, "Object modelling by registration of multiple range
            images", Image and Vision Computing 10 (1992).
        """
        turns, begin = lying.turns, start / self.size
        known = np.isfinite(begin.sum(axis=1, keepdims=True))
        places = np.where(known, begin, 0.0)
        # The normals of a mirrored patch still look outward.
        for _ in range(ROUNDS):
            arms, facing = own.offsets @ turns, own.facing @ turns
            at = places[:, None] + arms
            matched = self._tree.query(np.concatenate([at, NORMALS * facing], axis=2).reshape(-1, 6))[1]
            goals, planes = (values[matched].reshape(at.shape) for values in (self.points, self.facing))
            step = _step(own.weights, arms, goals - at, planes, np.where(known, begin - places, 0.0))
            turns = turns @ Rotation.from_rotvec(step[:, :3]).as_matrix().transpose(0, 2, 1)
            places = places + step[:, 3:]
        return np.where(known, places * self.size, np.nan)


def _step(
    w: np.ndarray, arms: np.ndarray, off: np.ndarray, planes: np.ndarray, home: np.ndarray
) -> Float[np.ndarray, "L 6"]:
    """(L, 6) the turn, as a vector, and the shift that bring patches nearest to their planes, by least squares.

    Args:
        w: (L, K) weights; arms: (L, K, 3) from the points that are turned about; off: (L, K, 3) from the patch to what
            it is matched with; planes: (L, K, 3) normals there; home: (L, 3) the way back.
    """
    rows = np.concatenate([np.cross(arms, planes), planes], axis=2)
    left = np.einsum("lk,lki,lkj->lij", w, rows, rows)
    right = np.einsum("lk,lki,lk->li", w, rows, np.einsum("lkx,lkx->lk", off, planes))
    # d/dθ of θ × arm, a row a coordinate, and the unit matrix of the shift.
    J = np.zeros((*arms.shape, 6))
    a, b, c = np.moveaxis(arms, 2, 0)
    J[..., 0, 1], J[..., 0, 2], J[..., 1, 0] = c, -b, -c
    J[..., 1, 2], J[..., 2, 0], J[..., 2, 1] = a, b, -a
    J[..., 3:] = np.eye(3)
    left += ALONG * np.einsum("lk,lkxi,lkxj->lij", w, J, J)
    right += ALONG * np.einsum("lk,lkxi,lkx->li", w, J, off)
    left[:, [0, 1, 2], [0, 1, 2]] += STIFF * RADIUS**2
    left[:, [3, 4, 5], [3, 4, 5]] += HOLD
    right[:, 3:] += HOLD * home
    return np.linalg.solve(left, right[..., None])[..., 0]
