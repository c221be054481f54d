"""From a matrix that some algebra has made back to an operator that a shape could have."""

import torch
from jaxtyping import Float
from torch import Tensor

from lssd_learn.operators.matrices import as_operators, extend, null_functions, restrict

# Of the largest eigenvalue. Bodies differ from their mean by factors of four at most, in either direction.
FLOOR = 0.01


def positive_part(X, floor: float = FLOOR) -> Float[Tensor, "*s m m"]:
    """The symmetric part of X with no eigenvalue below `floor` times the largest, so that it has a logarithm.

    A product of symmetric operators is not symmetric, and a sum with negative weights need not be positive definite.
    What is both already, with eigenvalues above the floor, stays as it is.

    Args:
        X: (…, m, m).
        floor: part of the largest eigenvalue.

    Returns:
        (…, m, m) float64; functions null in all X, see `matrices.py`, stay null.

    Raises:
        InputError: not square matrices of finite numbers.
    """
    X = as_operators("X", X)
    live = ~null_functions(X)
    evals, V = torch.linalg.eigh((restrict(X, live) + restrict(X, live).mT) / 2)
    evals = evals.maximum(floor * evals.abs().amax(-1, keepdim=True))
    return extend((V * evals[..., None, :]) @ V.mT, live)
