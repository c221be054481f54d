"""The smallest eigenpairs of a large symmetric operator: block Lanczos on its shifted inverse.

The eigenbasis of a shape comes from here, though nothing in it knows of shapes. ARPACK takes one vector at a time and
spends most of its time making it orthogonal; small blocks turn that into matrix products, and let the factorisation
solve for several right-hand sides at once.
"""

from collections.abc import Callable

import numpy as np

DENSE = 256  # below this size, or when most of the spectrum is wanted, a dense solver is faster
SPARE = 2  # blocks between two looks at the convergence


def smallest_eigenpairs(
    solve: Callable[[np.ndarray], np.ndarray],
    n: int,
    k: int,
    shift: float,
    *,
    block: int = 6,
    tolerance: float = 1e-9,
    seed: int = 0,
) -> tuple[np.ndarray, np.ndarray]:
    """The k smallest eigenpairs of a symmetric positive semi-definite n × n operator A, by block Lanczos.

    Every new block is orthogonalised against all others, so multiple eigenvalues come with all their copies, and the
    result has the same bits whenever `solve` has. Convergence is fastest with the shift about half way up the wanted
    eigenvalues; one below zero keeps A − shift·I definite.

    Args:
        solve: X (n, b) → (A − shift·I)⁻¹ X.
        n: size of A.
        k: number of pairs, 1 ≤ k ≤ n.
        shift: not an eigenvalue of A.
        block: number of vectors that advance together.
        tolerance: bound of ‖(A − shift·I)⁻¹ x − θx‖ / |θ| of every pair returned, θ = 1 / (λ − shift).
        seed: of the random start.

    Returns:
        eigenvalues (k,), ascending, and eigenvectors (n, k), orthonormal columns.

    Raises:
        ArithmeticError: the solver breaks down or does not converge.

    Reference:
        Grimes, Lewis and Simon, "A shifted block Lanczos algorithm for solving sparse symmetric generalized
        eigenproblems", SIAM J. Matrix Anal. Appl. 15 (1994).
    """
    if n <= max(DENSE, 3 * k):
        inverse = solve(np.eye(n))
        theta, X = np.linalg.eigh((inverse + inverse.T) / 2)
        wanted, values = _smallest(theta, shift, k)
        if len(wanted) < k:
            raise ArithmeticError(f"only {len(wanted)} of {k} eigenvalues are not negative")
        return values, X[:, wanted]

    # Row by row: both products of the orthogonalisation then stream Q once, whatever the size of the block.
    Q = np.empty((min(n, 12 * k + 40 * block) // block * block, n))  # the basis so far: untouched rows cost no memory
    T = np.zeros((len(Q), len(Q)))  # Q (A − shift·I)⁻¹ Qᵀ
    W = np.random.default_rng(seed).standard_normal((block, n))
    Q[:block] = np.linalg.qr(W.T)[0].T
    look = 2 * k + 4 * block
    for m in range(block, len(Q), block):
        latest, near = slice(m - block, m), slice(max(0, m - 2 * block), m)
        W = np.ascontiguousarray(solve(Q[latest].T).T)
        # First the two neighbouring blocks, which hold all but rounding errors, then everything: orthogonal to the
        # last digit at the price of one pass.
        H = np.zeros((block, m))
        H[:, near] = W @ Q[near].T
        W -= H[:, near] @ Q[near]
        correction = W @ Q[:m].T
        W -= correction @ Q[:m]
        H += correction
        T[latest, :m] = H
        T[:m, latest] = H.T
        Q[m : m + block], R = _orthonormalise(W, Q[:m])
        if m >= look:
            theta, S = np.linalg.eigh(T[:m, :m])
            wanted, values = _smallest(theta, shift, k)
            if len(wanted) == k:
                residuals = np.linalg.norm(R @ S[latest][:, wanted], axis=0) / np.abs(theta[wanted])
                if residuals.max() <= tolerance:
                    return values, Q[:m].T @ S[:, wanted]
            look = m + max(SPARE * block, m // 16)
    raise ArithmeticError(f"{k} eigenpairs did not converge in a basis of {len(Q)} vectors")


def _smallest(theta: np.ndarray, shift: float, k: int) -> tuple[np.ndarray, np.ndarray]:
    """The positions in theta of the k smallest λ = shift + 1/θ ≥ 0, and those λ; fewer if fewer are there.

    An operator without negative eigenvalues has no θ between −1/shift and 0: what is found there has not converged.
    """
    lowest = -(1 - 1e-6) / shift if shift > 0 else -np.inf
    possible = np.flatnonzero((theta > 0) | (theta <= lowest))
    values = shift + 1 / theta[possible]
    order = np.argsort(values, kind="stable")[:k]
    return possible[order], values[order]


def _orthonormalise(W: np.ndarray, Q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """X, R with Wᵀ = Xᵀ R, the rows of X orthonormal and orthogonal to those of Q, R upper triangular."""
    try:
        X, R = W, np.eye(len(W))
        for _ in range(2):  # the second round repairs what the first loses (Yamamoto et al., "CholeskyQR2", 2015)
            C = np.linalg.cholesky(X @ X.T)
            if C.diagonal().min() < 1e-6 * C.diagonal().max():
                raise np.linalg.LinAlgError
            X, R = np.linalg.inv(C) @ X, C.T @ R
        return X, R
    except np.linalg.LinAlgError:  # a direction has run dry: what is left of it is noise, not orthogonal to Q
        X, R = np.linalg.qr(W.T)
        X -= Q.T @ (Q @ X)
        X, S = np.linalg.qr(X)
        return X.T, S @ R
