"""The smallest eigenpairs of a large symmetric operator: block Lanczos on its shifted inverse.

The eigenbasis of a shape comes from here, though nothing in it knows of shapes. ARPACK takes one vector at a time and
spends most of its time making it orthogonal; small blocks turn that into matrix products, and let the factorisation
solve for several right-hand sides at once.

A new block is made orthogonal to the two before it, which in exact arithmetic is enough. What rounding brings of the
others grows from block to block, and is harmless while it is small (Simon 1984, "The Lanczos algorithm with partial
reorthogonalization"): every `GROUP` blocks the last ones are made orthogonal to all others together, in products as
wide as they are, which the processor does twice as fast as narrow ones.
"""

import math
from collections.abc import Callable

import numpy as np

DENSE = 256  # below this size, or when most of the spectrum is wanted, a dense solver is faster
SPARE = 2  # blocks between two looks at the convergence, while there is none
FILTERED = 4  # times the random start is solved for: so many blocks fewer are kept, for as many solves
GROUP = 2  # blocks that are made orthogonal to all others together: what one takes costs as much as what two take
LOST = 1e-6  # of orthogonality by then: the blocks may have gone astray, and every one has to be looked after
WELL = 0.03  # a block of lengths as like as that
LOW = 1e-2  # eigenvalues below this part of the largest need be no more exact than one of that size


def smallest_eigenpairs(
    solve: Callable[[np.ndarray], np.ndarray],
    n: int,
    k: int,
    shift: float,
    *,
    block: int = 6,
    tolerance: float = 3e-7,
    seed: int = 0,
) -> tuple[np.ndarray, np.ndarray]:
    """The k smallest eigenpairs of a symmetric positive semi-definite n × n operator A, by block Lanczos.

    Multiple eigenvalues come with all their copies, and the result has the same bits whenever `solve` has. Convergence
    is fastest with the shift about half way up the wanted eigenvalues; one below zero keeps A − shift·I definite.

    Args:
        solve: X (n, b) → (A − shift·I)⁻¹ X.
        n: size of A.
        k: number of pairs, 1 ≤ k ≤ n.
        shift: not an eigenvalue of A.
        block: number of vectors that advance together.
        tolerance: bound of ‖A x − λx‖ / λ of every pair returned; of a λ below a hundredth of the largest, relative to
            that.
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
    start = np.random.default_rng(seed).standard_normal((block, n))
    found = _lanczos(solve, start, k, shift, tolerance, GROUP) or _lanczos(solve, start, k, shift, tolerance, 1)
    if found is None:
        most = len(_room(block, n, k))
        raise ArithmeticError(f"{k} eigenpairs did not converge in a basis of {most} vectors")
    return found


def _room(block: int, n: int, k: int) -> np.ndarray:
    """Where the basis goes, row by row: untouched rows cost no memory."""
    return np.empty((min(n, 12 * k + 40 * block) // block * block, n))


def _lanczos(
    solve: Callable[[np.ndarray], np.ndarray], start: np.ndarray, k: int, shift: float, tolerance: float, group: int
) -> tuple[np.ndarray, np.ndarray] | None:
    """See `smallest_eigenpairs`; None if it does not converge, or loses orthogonality within a group of blocks."""
    block, n = start.shape
    Q = _room(block, n, k)
    T = np.zeros((len(Q), len(Q)))  # Q (A − shift·I)⁻¹ Qᵀ
    for _ in range(FILTERED):
        start = np.linalg.qr(solve(start.T))[0].T
    Q[:block] = np.linalg.qr(start.T)[0].T
    clean, look = block, 7 * k // 4
    for m in range(block, len(Q), block):
        latest, near = slice(m - block, m), slice(max(0, m - 2 * block), m)
        W = np.ascontiguousarray(solve(Q[latest].T).T)
        H = W @ Q[near].T
        W -= H @ Q[near]
        T[latest, near], T[near, latest] = H, H.T
        Q[m : m + block], R = _orthonormalise(W, Q[:m])
        if m + block - clean >= group * block:
            lost = _reorthogonalise(Q[:clean], Q[clean : m + block])
            if lost > LOST:
                if group > 1:
                    return None
                _reorthogonalise(Q[:clean], Q[clean : m + block])
            clean = m + block
        if m >= look:
            blocks = SPARE
            theta, S = np.linalg.eigh(T[:m, :m])
            wanted, values = _smallest(theta, shift, k)
            if len(wanted) == k:
                # (A − shift·I)⁻¹ x = θ x + Qᵀ R s: the next block holds what is missing of x, to first order (Ericsson
                # & Ruhe 1980). With it A x − λx is (λ − shift) times that, and no longer what is sharpest in it.
                S, missing = S[:, wanted], R @ S[latest][:, wanted] / theta[wanted]
                scale = np.maximum(values, LOW * max(values[-1], abs(shift)))
                worst = (np.linalg.norm(missing, axis=0) * np.abs(values - shift) / scale).max()
                if worst <= tolerance:
                    _reorthogonalise(Q[:clean], Q[clean : m + block])
                    S = np.concatenate([S, missing])
                    S -= S @ (missing.T @ missing) / 2  # orthonormal again, to first order
                    return values, Q[: m + block].T @ S
                blocks = math.ceil(1.3 * math.log10(worst / tolerance))  # of meshes it falls six times a block, or less
            look = m + block * max(blocks, m // 32 // block, 1)
    return None


def _smallest(theta: np.ndarray, shift: float, k: int) -> tuple[np.ndarray, np.ndarray]:
    """The positions in theta of the k smallest λ = shift + 1/θ ≥ 0, and those λ; fewer if fewer are there.

    An operator without negative eigenvalues has no θ between −1/shift and 0: what is found there has not converged.
    """
    lowest = -(1 - 1e-6) / shift if shift > 0 else -np.inf
    possible = np.flatnonzero((theta > 0) | (theta <= lowest))
    values = shift + 1 / theta[possible]
    order = np.argsort(values, kind="stable")[:k]
    return possible[order], values[order]


def _reorthogonalise(old: np.ndarray, new: np.ndarray) -> float:
    """Make the rows of `new` orthonormal and orthogonal to those of `old`, which they nearly are; by how much not."""
    if not len(new):
        return 0.0
    across = new @ old.T
    new -= across @ old
    gram = new @ new.T
    lost = max(np.abs(across).max(), np.abs(gram - np.eye(len(gram))).max())
    new[:] = np.linalg.inv(np.linalg.cholesky(gram)) @ new if lost < 0.01 else np.linalg.qr(new.T)[0].T
    return float(lost)


def _orthonormalise(W: np.ndarray, Q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """X, R with Wᵀ = Xᵀ R, the rows of X orthonormal and orthogonal to those of Q, R upper triangular."""
    try:
        X, R = W, np.eye(len(W))
        for _ in range(2):  # the second round repairs what the first loses (Yamamoto et al., "CholeskyQR2", 2015)
            C = np.linalg.cholesky(X @ X.T)
            least, most = C.diagonal().min(), C.diagonal().max()
            if least < 1e-6 * most:
                raise np.linalg.LinAlgError
            X, R = np.linalg.inv(C) @ X, C.T @ R
            if least > WELL * most:  # it has lost next to nothing
                break
        return X, R
    except np.linalg.LinAlgError:  # a direction has run dry: what is left of it is noise, not orthogonal to Q
        X, R = np.linalg.qr(W.T)
        X -= Q.T @ (Q @ X)
        X, S = np.linalg.qr(X)
        return X.T, S @ R
