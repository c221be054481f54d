"""A is to B as C is to …"""

import torch
from jaxtyping import Float
from torch import Tensor

from lssd_learn.errors import InputError
from lssd_learn.operators.logarithms import exponential, logarithm
from lssd_learn.operators.matrices import SMALLEST, as_like_operators, extend, null_functions, restrict


def analogy(A, B, C, method: str = "multiplicative") -> Float[Tensor, "*s m m"]:
    """The operator that is to C what B is to A. analogy(A, B, A) is B, and analogy(A, A, C) is C.

    Args:
        A, B, C: (…, m, m) of one latent space; they broadcast.
        method: "multiplicative" is B A⁻¹ C, of the paper: not symmetric, and its eigenvalues need not be real. Takes
            both forms of conformal operators. "log_euclidean" is exp(log C + log B − log A): symmetric positive
            definite, and the same where all three commute; takes symmetric positive definite operators.

    Returns:
        (…, m, m) float64; functions null in all three, see `matrices.py`, are null (row and column).

    Raises:
        InputError: sizes that do not fit, an unknown method; A is singular on the live functions; for log_euclidean, an
            operator that is not symmetric positive definite.

    Source: "Reconstruction" in the paper. Its additive analogy works on activations of a network, not here.

    Examples:
        >>> import torch
        >>> from lssd_learn.operators import analogy
        >>> one = torch.eye(2)
        >>> analogy(one, 2 * one, 3 * one).diag().tolist()  # twice as large is to one as six times to three
        [6.0, 6.0]
    """
    A, B, C = as_like_operators(A=A, B=B, C=C)
    null = null_functions(A, B, C)
    if method == "log_euclidean":
        return exponential(logarithm(C, null) + logarithm(B, null) - logarithm(A, null), null)
    if method != "multiplicative":
        raise InputError(f"method={method!r}: expected multiplicative or log_euclidean")
    A, B, C = (restrict(D, ~null) for D in (A, B, C))
    sizes = torch.linalg.svdvals(A)
    if (sizes[..., -1:] <= SMALLEST * sizes[..., :1]).any():
        raise InputError("A: expected an invertible operator on the functions that are not null")
    return extend(B @ torch.linalg.solve(A, C), ~null)
