"""Distances along a surface, good enough to score maps with: shortest paths in a graph on the vertices."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float, Int
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from lssd_learn.kdtree import cKDTree
from lssd_learn.shapes.edges import edges
from lssd_learn.shapes.mesh import Mesh, Shape

NEIGHBOURS = 8  # of a point of a cloud
CHUNK = 2**24  # distances held at a time


def geodesic_distances(
    shape: Shape, starts: Sequence[int] | Int[np.ndarray, " m"], ends: Sequence[int] | Int[np.ndarray, " m"]
) -> Float[np.ndarray, " m"]:
    """(m,) lengths of shortest paths from vertex starts[i] to vertex ends[i], in the unit of length of the shape.

    Never too short on a flat surface, and too long by at most 3.6 % on a flat lattice of equilateral triangles (15.5 %
    along edges alone); infinite between separate pieces. On a cloud paths go from point to near point.

    Args:
        shape: V vertices.
        starts, ends: (m,).
    """
    connected = graph(shape)
    starts, ends = np.asarray(starts), np.asarray(ends)
    firsts, row = np.unique(starts, return_inverse=True)
    lengths = np.empty(len(starts))
    rows = max(1, CHUNK // len(shape.vertices))
    for begin in range(0, len(firsts), rows):
        here = (row >= begin) & (row < begin + rows)
        table = dijkstra(connected, directed=False, indices=firsts[begin : begin + rows])
        lengths[here] = table[row[here] - begin, ends[here]]
    return lengths


def graph(shape: Shape) -> csr_array:
    """(V, V) lengths of edges, and of straight lines across each edge between the corners opposite to it."""
    points, n = shape.vertices, len(shape.vertices)
    if isinstance(shape, Mesh):
        sides = edges(shape.faces)
        lengths = np.linalg.norm(points[sides[:, 0]] - points[sides[:, 1]], axis=1)
        corners, across = _diagonals(shape)
        pairs, lengths = np.concatenate([sides, corners]), np.concatenate([lengths, across])
    else:
        near, index = cKDTree(points).query(points, min(NEIGHBOURS + 1, n))
        pairs = np.stack([np.repeat(np.arange(n), index.shape[1] - 1), index[:, 1:].ravel()], axis=1)
        lengths = near[:, 1:].ravel()
    # Of a pair that is there twice the shorter counts: a sparse matrix would add the two. Zero would be no edge.
    pairs = np.sort(pairs, axis=1)
    order = np.lexsort([lengths, pairs[:, 1], pairs[:, 0]])
    pairs, first = np.unique(pairs[order], axis=0, return_index=True)
    lengths = np.maximum(lengths[order][first], np.finfo(float).tiny)
    return csr_array((lengths, (pairs[:, 0], pairs[:, 1])), shape=(n, n))


def _diagonals(mesh: Mesh) -> tuple[np.ndarray, np.ndarray]:
    """Pairs (m, 2) of corners opposite to a common edge and their distances (m,), two triangles laid flat.

    Only where the straight line crosses that edge: elsewhere it leaves the two triangles.
    """
    ends = np.concatenate([mesh.faces[:, [0, 1]], mesh.faces[:, [1, 2]], mesh.faces[:, [2, 0]]])
    opposite = np.concatenate([mesh.faces[:, 2], mesh.faces[:, 0], mesh.faces[:, 1]])
    ends = np.sort(ends, axis=1)
    order = np.lexsort([ends[:, 1], ends[:, 0]])
    ends, opposite = ends[order], opposite[order]
    twin = np.flatnonzero((ends[1:] == ends[:-1]).all(axis=1))
    (a, b), c, d = mesh.vertices[ends[twin].T], *(mesh.vertices[opposite[twin + s]] for s in (0, 1))
    length = np.linalg.norm(b - a, axis=1)
    along = (b - a) / np.maximum(length, np.finfo(float).tiny)[:, None]
    (xc, yc), (xd, yd) = ((x, np.sqrt(np.maximum(np.einsum("ex,ex->e", p, p) - x**2, 0)))
                          for p in (c - a, d - a) for x in [np.einsum("ex,ex->e", p, along)])  # fmt: skip
    crosses = np.divide(xc * yd + xd * yc, yc + yd, out=np.full_like(length, -1.0), where=yc + yd > 0)
    inside = (crosses >= 0) & (crosses <= length)
    pairs = np.stack([opposite[twin], opposite[twin + 1]], axis=1)[inside]
    return pairs, np.hypot(xc - xd, yc + yd)[inside]
