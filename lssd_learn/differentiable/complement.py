"""(L − λ_j M) x_j = r_j off the eigenfunctions that are known: what the derivative of eigenfunctions asks for."""

import numpy as np
from jaxtyping import Float
from scipy.sparse import csr_array, dia_array

from lssd_learn.errors import InputError
from lssd_learn.shapes.eigenbasis import factorised

# Factorisations: with a shift near each λ_j a few rounds do. TOLERANCE is relative, of a solution in its own energy.
GROUPS, TOLERANCE, MOST = 8, 1e-11, 300
ROUNDING = 1e-13  # of a right-hand side


def solve_complement(
    L: csr_array,
    M: Float[np.ndarray, " V"],
    evals: Float[np.ndarray, " k"],
    evecs: Float[np.ndarray, "V k"],
    R: Float[np.ndarray, "V k"],
) -> Float[np.ndarray, "V k"]:
    """X (V, k) with (L − λ_j M) x_j = r_j − MΦΦᵀr_j and ΦᵀMX = 0.

    Off the k lowest eigenfunctions L − λ_j M is positive definite: conjugate gradients there, with the inverse of
    L − σM for a σ near λ_j, exact where they are equal, as the preconditioner.

    Args:
        L, M: stiffness and masses.
        evals, evecs: the k lowest eigenpairs Λ, Φ, ascending.
        R: right-hand sides, one an eigenvalue.

    Raises:
        InputError: no convergence, as where λ_k and the next eigenvalue are all but equal.
    """
    X = np.zeros_like(R)
    edges = np.linspace(0, evals[-1], GROUPS + 1)[1:-1]
    for some in np.split(np.arange(len(evals)), np.searchsorted(evals, edges)):
        if len(some):
            X[:, some] = _solve(L, M, evals[some], evecs, R[:, some], evals)
    return X


def _solve(L, M, shifts, evecs, R, evals):
    def primal(Z):  # M-orthogonal to Φ
        return Z - evecs @ (evecs.T @ (M[:, None] * Z))

    whole = np.linalg.norm(R, axis=0)
    R = R - M[:, None] * (evecs @ (evecs.T @ R))
    R[:, np.linalg.norm(R, axis=0) <= ROUNDING * whole] = 0  # all of it lies in the span
    inverse = _near(L, M, shifts, evals)
    X, P = np.zeros_like(R), 0.0
    Z = primal(inverse(R))
    energy = (R * Z).sum(0)
    wanted = TOLERANCE**2 * energy.max()
    for _ in range(MOST):
        going = energy > wanted
        if not going.any():
            return primal(X)
        P = Z + P
        AP = L @ P - M[:, None] * P * shifts
        step = np.where(going, energy / np.where(going, (P * AP).sum(0), 1), 0)
        X, R = X + step * P, R - step * AP
        Z = primal(inverse(R))
        before, energy = energy, (R * Z).sum(0)
        P = P * np.where(going, energy / np.where(going, before, 1), 0)
    raise InputError(
        f"eigenbasis: no derivative found for k={len(evals)}: the next eigenvalue is too near; take another k"
    )


def _near(L, M, shifts, evals):
    """The inverse of L − σM, σ half way between two eigenvalues, as near to the middle of `shifts` as can be."""
    middle = (shifts[0] + shifts[-1]) / 2
    known = np.concatenate([[-evals[-1] / len(evals)], evals])
    halves = (known[1:] + known[:-1])[np.diff(known) > 1e-3 * evals[-1] / len(evals)] / 2
    for shift in halves[np.argsort(np.abs(halves - middle))]:
        solve = factorised((L - dia_array((shift * M[None], 0), shape=L.shape)).tocsc(), definite=shift < 0)
        if solve is not None:
            return solve
    raise InputError("eigenbasis: no derivative found: the Laplacian cannot be factorised")
