"""The edges of a mesh and their lengths: what tells shapes apart that share their faces."""

import numpy as np


def edges(faces: np.ndarray) -> np.ndarray:
    """(E, 2) every edge of a mesh once, its lower vertex first, in ascending order; faces are (F, 3)."""
    sides = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
    return np.unique(sides, axis=0)


def edge_lengths(vertices: np.ndarray, edges: np.ndarray) -> np.ndarray:
    """(E,) float64 the lengths of edges (E, 2), in the unit of the vertices (V, 3). Rigid motions change nothing."""
    start, end = np.asarray(vertices, dtype=np.float64)[edges.T]
    return np.linalg.norm(end - start, axis=1)
