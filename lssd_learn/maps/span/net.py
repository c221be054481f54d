"""A net of points on a surface, each of which turns and moves by itself: the surface follows, and bends at joints."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int
from scipy.sparse.csgraph import dijkstra

from lssd_learn.shapes import Mesh
from lssd_learn.shapes.geodesics import graph
from lssd_learn.shapes.sampling import farthest_points

KNOTS, LEAST = 200, 6  # and vertices for each
FOLLOWED = 4  # knots that a vertex follows
JUMP = 100.0  # added to the distance of what no path leads to


@dataclass(frozen=True, eq=False)
class Net:
    """A net of n knots on a mesh of V vertices.

    Attributes:
        knots: (n,) vertices.
        followed: (V, f) the knots that a vertex follows, the nearest along the surface, and
        shares: (V, f) how much each; of sum 1.
        i, j: (m,) knots that some vertex follows both of, each pair both ways.
    """

    knots: Int[np.ndarray, " n"]
    followed: Int[np.ndarray, "V f"]
    shares: Float[np.ndarray, "V f"]
    i: Int[np.ndarray, " m"]
    j: Int[np.ndarray, " m"]


def net(mesh: Mesh) -> Net:
    """A net on a mesh, of knots spread out over it.

    Reference:
        Shares after Sumner, Schmid and Pauly, "Embedded deformation for shape manipulation", ACM Transactions on
        Graphics 26 (2007), with distances along the surface.
    """
    points = mesh.vertices
    knots = farthest_points(points, min(KNOTS, 1 + len(points) // LEAST))
    away = dijkstra(graph(mesh), directed=False, indices=knots).T
    lost = ~np.isfinite(away)
    away[lost] = JUMP + np.linalg.norm(points[:, None] - points[knots], axis=2)[lost] if lost.any() else 0
    count = min(FOLLOWED, len(knots) - 1)
    order = np.argpartition(away, count, axis=1)[:, : count + 1]
    near = np.take_along_axis(away, order, axis=1)
    rank = np.argsort(near, axis=1)
    order, near = np.take_along_axis(order, rank, axis=1), np.take_along_axis(near, rank, axis=1)
    shares = (1 - near[:, :count] / near[:, count:]) ** 2 + 1e-9
    followed = order[:, :count]
    a, b = (followed[:, pair].ravel() for pair in np.triu_indices(count, 1))
    i, j = np.divmod(np.unique(np.concatenate([a * len(knots) + b, b * len(knots) + a])), len(knots))
    return Net(knots, followed, shares / shares.sum(axis=1, keepdims=True), i, j)
