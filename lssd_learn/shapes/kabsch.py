"""The rotation that lays points upon others they are matched with."""

import numpy as np
from jaxtyping import Float, Shaped


def kabsch(
    points: Float[np.ndarray, "... N 3"],
    goals: Float[np.ndarray, "... N 3"],
    weights: Shaped[np.ndarray, "... N"] | None = None,
) -> Float[np.ndarray, "... 3 3"]:
    """The rotation R (…, 3, 3) of least Σ w ‖points R − goals‖², for rows that are centred, in the sense of weights.

    Args:
        points, goals: (…, N, 3), many sets at once.
        weights: (…, N); None weighs all alike.

    Reference:
        Kabsch, "A solution for the best rotation to relate two sets of vectors", Acta Crystallographica A32 (1976).
    """
    weighed = points if weights is None else weights[..., None] * points
    return nearest_rotation(np.swapaxes(weighed, -1, -2) @ goals)


def nearest_rotation(matrix: Float[np.ndarray, "*sets 3 3"]) -> Float[np.ndarray, "*sets 3 3"]:
    """The rotation nearest to (…, 3, 3) matrices, which is also the one of greatest trace(Rᵀ matrix)."""
    U, _, Vt = np.linalg.svd(matrix)
    U[..., -1] *= np.sign(np.linalg.det(U @ Vt))[..., None]
    return U @ Vt


def nearest_orthogonal(matrix: Float[np.ndarray, "*sets 3 3"]) -> Float[np.ndarray, "*sets 3 3"]:
    """The orthogonal matrix, of either determinant, nearest to (…, 3, 3) matrices."""
    U, _, Vt = np.linalg.svd(matrix)
    return U @ Vt


def vertex_error(points: Float[np.ndarray, "N 3"], truth: Float[np.ndarray, "N 3"]) -> float:
    """The mean distance of points (N, 3) to their true places (N, 3) after the best rotation and shift."""
    points, truth = (x - x.mean(axis=0) for x in (points, truth))
    return float(np.linalg.norm(points @ kabsch(points, truth) - truth, axis=1).mean())
