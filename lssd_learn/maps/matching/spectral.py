"""Fourth step of matching: a rough match of spread points becomes a map with more and more eigenfunctions."""

import numpy as np

from lssd_learn.maps.matching.prepared import Prepared

RIDGE = 1e-6  # of the mean square of a function: keeps the normal equations solvable where points are few
STEP = 10  # functions more a round
FULL = 80  # functions in the end


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


def zoomed(source: Prepared, target: Prepared, C: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """What samples are matched with by C (k, k) after ZoomOut: (n_target,) vertices of the source, (n_source,) others.

    See `zoomout.zoomout`; here least squares on spread points, which costs the square of their number and not of all
    vertices.
    """
    S, T = source.embedding[source.samples], target.embedding[target.samples]
    most = min(FULL, source.basis.k, target.basis.k)
    for k in (*range(len(C) + STEP, most, STEP), most):
        there = nearest(S[:, : len(C)], T[:, : len(C)] @ C)
        C = fitted(T[:, :k], S[there, :k])
    there, back = nearest(S[:, :most], T[:, :most] @ C), nearest(T[:, :most] @ C, S[:, :most])
    return source.samples[there], target.samples[back]
