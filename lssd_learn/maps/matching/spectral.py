"""Points matched by eigenfunctions: nearest rows and least squares, on spread points."""

import numpy as np

from lssd_learn.maps.matching.prepared import Prepared

RIDGE = 1e-6  # of the mean square of a function: keeps the normal equations solvable where points are few


def nearest(A: np.ndarray, B: np.ndarray) -> np.ndarray:
    """(m,) for each row of B (m, d) the number of the nearest row of A (n, d), both in single precision.

    A matrix product: at d of 50 and more faster than any tree.
    """
    squares = np.einsum("nd,nd->n", A, A)
    found = np.empty(len(B), dtype=np.int64)
    for start in range(0, len(B), 1024):
        found[start : start + 1024] = (squares - 2 * B[start : start + 1024] @ A.T).argmin(axis=1)
    return found


def fitted(P: np.ndarray, Q: np.ndarray) -> np.ndarray:
    """C (k, l), the least squares solution of P C = Q; P (n, k) and Q (n, l) are values at n corresponding points."""
    gram = (P.T @ P).astype(float)
    gram[np.diag_indices_from(gram)] += RIDGE * len(P)
    return np.linalg.solve(gram, (P.T @ Q).astype(float)).astype(P.dtype)


def samples_matched(source: Prepared, target: Prepared, C: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """What samples are matched with by C (k, k): (n_target,) vertices of the source and (n_source,) of the target."""
    S = source.embedding[source.samples, : len(C)]
    T = target.embedding[target.samples, : len(C)] @ C
    return source.samples[nearest(S, T)], target.samples[nearest(T, S)]
