"""A coarse net of points on a shape, and how the shape follows it: bends settle there in a few steps."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from lssd_learn.maps.matching.elastic import Elastic
from lssd_learn.maps.matching.prepared import Prepared

KNOTS = (200, 500)  # of a first net and of a second
EQUILATERAL = 1 / np.sqrt(3)  # the cotangent weight of an edge in a net of equilateral triangles
LEAST_WEIGHT = 1e-4  # of an edge of the mesh: cotangents of obtuse angles are negative, and bending needs an energy
NET_BLUR, MESH_BLUR = 4, 20  # rounds of averaging, see `Elastic`


@dataclass(frozen=True, eq=False)
class Lattice:
    """A net of n points of a shape, joined where their cells on the surface touch.

    Attributes:
        shape: the shape, V vertices.
        knots: (n,) vertices.
        cell: (V,) for each vertex the number of the knot that is nearest along the surface.
        i, j: (m,) joined knots, each pair both ways.
    """

    shape: Prepared
    knots: np.ndarray
    cell: np.ndarray
    i: np.ndarray
    j: np.ndarray

    def elastic(self) -> Elastic:
        """The net, to be bent."""
        weights = np.full(len(self.i), EQUILATERAL)
        return Elastic(self.shape.points[self.knots], self.i, self.j, weights, NET_BLUR)

    @cached_property
    def _following(self) -> csr_array:
        """(V, n) how much each vertex follows its own knot and those joined to it; rows sum to 1."""
        n, points = len(self.knots), self.shape.points
        near = csr_array((np.ones(len(self.i)), (self.i, self.j)), shape=(n, n)) + csr_array(np.eye(n))
        share = csr_array(near.tocsr()[self.cell])
        rows = np.repeat(np.arange(len(points)), np.diff(share.indptr))
        away = ((points[rows] - points[self.knots[share.indices]]) ** 2).sum(axis=1)
        width = 2 * np.pi / n  # about the square of the way to the next knot, at unit area
        weights = np.exp(-away / width) + 1e-12
        sums = np.bincount(rows, weights, minlength=len(points))
        return csr_array((weights / sums[rows], share.indices, share.indptr), shape=share.shape)

    def followed(self, elastic: Elastic, knots: np.ndarray, vertices: np.ndarray | None = None) -> np.ndarray:
        """(V, 3) where the shape is when the knots are at `knots` (n, 3), turned and stretched as in `elastic`.

        Or (m, 3) of these m vertices.
        """
        moves = elastic.stretch @ elastic.turns
        shifts = knots - np.einsum("na,nab->nb", self.shape.points[self.knots], moves)
        following, points = self._following, self.shape.points
        if vertices is not None:
            following, points = following[vertices], points[vertices]
        followed = following @ np.hstack([moves.reshape(-1, 9), shifts])
        return np.einsum("va,vab->vb", points, followed[:, :9].reshape(-1, 3, 3)) + followed[:, 9:]

    def facing(self, elastic: Elastic, vertices: np.ndarray) -> np.ndarray:
        """(m, 3) unit normals of m vertices, turned as the knots of `elastic` are; a stretch is not minded."""
        turns = (self._following[vertices] @ elastic.turns.reshape(-1, 9)).reshape(-1, 3, 3)
        turned = np.einsum("va,vab->vb", self.shape.normals[vertices], turns)
        return turned / np.maximum(np.linalg.norm(turned, axis=1, keepdims=True), np.finfo(float).tiny)


def lattices(shape: Prepared) -> list[Lattice]:
    """Nets of a shape, the coarser first."""
    return [_lattice(shape, shape.samples[: min(count, len(shape.samples))]) for count in KNOTS]


def _lattice(shape: Prepared, knots: np.ndarray) -> Lattice:
    _, _, sources = dijkstra(shape.graph, directed=False, indices=knots, return_predecessors=True, min_only=True)
    number = np.full(len(shape.points), -1)
    number[knots] = np.arange(len(knots))
    cell = number[sources]
    a, b = (cell[ends] for ends in shape.shape.faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2).T)
    codes = np.unique((np.minimum(a, b) * len(knots) + np.maximum(a, b))[a != b])
    first, second = np.divmod(codes, len(knots))
    return Lattice(shape, knots, cell, np.concatenate([first, second]), np.concatenate([second, first]))


def mesh_elastic(shape: Prepared) -> Elastic:
    """All vertices of a shape, to be bent."""
    edges = shape.stiffness.tocoo()
    off = edges.row != edges.col
    return Elastic(
        shape.points, edges.row[off], edges.col[off], np.maximum(np.negative(edges.data[off]), LEAST_WEIGHT), MESH_BLUR
    )
