"""Residual randomisation: sums of squares of a term in data made anew from the model without it.

Under the model without the term, its residuals could have come in another order: Y* = fitted + permuted residuals. All
that is asked of Y* is asked of the permuted residuals E* alone, since what is fitted adds nothing to the term, nor to
the residuals of the whole model. With Q an orthonormal basis of the whole design and U = QA one of what the term adds,
T = QᵀE* has all of it: the term's sum of squares ‖AᵀT‖², and the residual one ‖E‖² − ‖T‖².

Source: Freedman & Lane, "A nonstochastic interpretation of reported significance levels", Journal of Business &
Economic Statistics 1 (1983); Anderson & ter Braak, Journal of Statistical Computation and Simulation 73 (2003);
Collyer, Sekora & Adams, "A method for analysis of phenotypic change for phenotypes described by high-dimensional data",
Heredity 115 (2015).
"""

from collections.abc import Iterator

import numpy as np
from jaxtyping import Float, Int

# So many numbers of permuted designs at a time, for a bounded memory.
CHUNK = 4_000_000


def permuted_products(
    E: Float[np.ndarray, "u r"], Q: Float[np.ndarray, "u p"], rows: Int[np.ndarray, "N u"]
) -> Iterator[tuple[slice, Float[np.ndarray, "M p r"]]]:
    """Which permutations, and T = QᵀE* of these, some at a time: E*[rows[b, i]] is E[i], summed over i.

    Args:
        E: residuals of the model without the term.
        Q: an orthonormal basis of the whole design.
        rows: of a `Stratum`.
    """
    (u, r), p = E.shape, Q.shape[1]
    many = max(1, CHUNK // max(1, p * max(u, r)))
    for first in range(0, len(rows), many):
        some = slice(first, min(first + many, len(rows)))
        W = np.ascontiguousarray(Q[rows[some]].transpose(0, 2, 1)).reshape(-1, u)
        yield some, (W @ E).reshape(-1, p, r)


def permuted_sums(
    Y: Float[np.ndarray, "u r"],
    U: Float[np.ndarray, "u q"],
    R: Float[np.ndarray, "u k"],
    Q: Float[np.ndarray, "u p"],
    rows: Int[np.ndarray, "N u"],
) -> tuple[Float[np.ndarray, " N"], Float[np.ndarray, " N"]]:
    """Sums of squares (N,) of a term and of the residuals of the whole model, first of the data themselves.

    Args:
        Y: of the units of a stratum.
        U, R: orthonormal, what the term adds and the model without it.
        Q: orthonormal, the whole design; U and R are in its span.
        rows: of the stratum.
    """
    E = Y - R @ (R.T @ Y)
    A, total = Q.T @ U, np.square(E).sum()
    term, rest = np.empty(len(rows)), np.empty(len(rows))
    for some, T in permuted_products(E, Q, rows):
        term[some] = np.square(A.T @ T).sum((1, 2))
        rest[some] = np.maximum(total - np.square(T).sum((1, 2)), 0)
    return term, rest
