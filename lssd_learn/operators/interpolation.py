"""Paths from one shape to another."""

import torch
from jaxtyping import Float
from torch import Tensor

from lssd_learn.errors import InputError
from lssd_learn.operators.logarithms import exponential, logarithm
from lssd_learn.operators.matrices import as_float64, as_like_operators, null_functions


def interpolate(D, E, t, method: str = "linear") -> Float[Tensor, "*s m m"]:
    """The operators at t on a path with D at 0 and E at 1.

    Args:
        D, E: (…, m, m) of one latent space; they broadcast.
        t: a number, or s of them (s,). Beyond 0 … 1 the path goes on.
        method: "linear" is (1 − t) D + t E, of the paper, positive definite between 0 and 1 where D and E are;
            "log_euclidean" is exp((1 − t) log D + t log E), positive definite for every t, of symmetric positive
            definite operators (their null functions, see `matrices.py`, stay null).

    Returns:
        (…, m, m), or (s, …, m, m) for s numbers, float64.

    Raises:
        InputError: sizes that do not fit, an unknown method, t that is not numbers; for log_euclidean, an operator that
            is not symmetric positive definite.

    Examples:
        >>> import torch
        >>> from lssd_learn.operators import interpolate
        >>> interpolate(torch.eye(2), 4 * torch.eye(2), 0.5, "log_euclidean").diag().round(decimals=4).tolist()
        [2.0, 2.0]
    """
    D, E = as_like_operators(D=D, E=E)
    t = as_float64(t).to(D)
    if t.ndim > 1 or not t.isfinite().all():
        raise InputError(f"t: expected a finite number or several in a row, got {tuple(t.shape)}")
    if method not in ("linear", "log_euclidean"):
        raise InputError(f"method={method!r}: expected linear or log_euclidean")
    null = null_functions(D, E)
    if method == "log_euclidean":
        D, E = logarithm(D, null), logarithm(E, null)
    D, E = torch.broadcast_tensors(D, E)
    t = t.reshape(t.shape + (1,) * D.ndim)
    path = (1 - t) * D + t * E
    return exponential(path, null) if method == "log_euclidean" else path
