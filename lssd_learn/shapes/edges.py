"""The edges of a mesh, their lengths and what they connect: from faces alone, for all that mends or compares."""

import numpy as np
from jaxtyping import Bool, Float, Int
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components


def edges(faces: Int[np.ndarray, "F 3"]) -> Int[np.ndarray, "E 2"]:
    """(E, 2) every edge of a mesh once, its lower vertex first, in ascending order; faces are (F, 3)."""
    sides = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
    return np.unique(sides, axis=0)


def edge_lengths(vertices: Float[np.ndarray, "V 3"], edges: Int[np.ndarray, "E 2"]) -> Float[np.ndarray, " E"]:
    """(E,) float64 the lengths of edges (E, 2), in the unit of the vertices (V, 3). Rigid motions change nothing."""
    start, end = np.asarray(vertices, dtype=np.float64)[edges.T]
    return np.linalg.norm(end - start, axis=1)


def border(faces: Int[np.ndarray, "F 3"]) -> Int[np.ndarray, "B 2"]:
    """(B, 2) the edges that only one face has, as they run in that face."""
    sides = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    n = faces.max(initial=-1) + 1
    _, first, count = np.unique(sides.min(axis=1) * n + sides.max(axis=1), return_index=True, return_counts=True)
    return sides[np.sort(first[count == 1])]


def pieces(faces: Int[np.ndarray, "F 3"], n_vertices: int) -> tuple[int, Int[np.ndarray, " V"]]:
    """How many connected pieces the faces form, and (V,) for each vertex the number of its piece, -1 if of no face."""
    label = groups(np.concatenate([faces[:, :2], faces[:, 1:]]), n_vertices)
    found, number = np.unique(label[faces[:, 0]], return_inverse=True)
    piece = np.full(n_vertices, -1)
    piece[faces] = number.reshape(-1, 1)
    return len(found), piece


def groups(pairs: Int[np.ndarray, "m 2"], n: int) -> Int[np.ndarray, " n"]:
    """(n,) for each of n things the number of its group, where pairs (m, 2) of them are connected."""
    graph = coo_array((np.ones(len(pairs), dtype=np.int8), tuple(pairs.T)), shape=(n, n))
    return connected_components(graph.tocsr(), directed=False)[1]


def face_groups(faces: Int[np.ndarray, "F 3"], kind: Bool[np.ndarray, " F"]) -> Int[np.ndarray, " F"]:
    """(F,) for each face the number of its patch: faces of one kind that share edges, directly or through others."""
    sides = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
    of = np.tile(np.arange(len(faces)), 3)
    keys = np.stack([sides[:, 0], sides[:, 1], np.tile(kind, 3)], axis=1)
    first, edge = np.unique(keys, axis=0, return_index=True, return_inverse=True)[1:]
    return groups(np.stack([of, of[first[edge.ravel()]]], axis=1), len(faces))
