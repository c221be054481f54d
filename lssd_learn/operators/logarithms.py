"""Logarithms and exponentials of symmetric operators: where shape differences add up.

Source: Arsigny, Fillard, Pennec and Ayache, "Log-Euclidean metrics for fast and simple calculus on diffusion tensors",
Magnetic Resonance in Medicine 56 (2006).
"""

import torch
from jaxtyping import Bool, Float
from torch import Tensor

from lssd_learn.errors import InputError
from lssd_learn.operators.matrices import as_operators, extend, null_functions, restrict, symmetric_eigh


def logarithm(D, null: Bool[Tensor, " m"] | None = None) -> Float[Tensor, "*s m m"]:
    """log D of symmetric positive definite operators: symmetric, zero for a shape that equals the latent one.

    Args:
        D: (…, m, m); conformal ones in their symmetric form.
        null: (m,) bool, functions to leave out; None finds them by the rule of `matrices.py`. They are zero in log D.

    Returns:
        (…, m, m) float64.

    Raises:
        InputError: not symmetric, or not positive definite (a condition number above a million is refused too) on the
            functions that are not null.
    """
    D = as_operators("D", D)
    live = ~_null(null, D)
    evals, V = symmetric_eigh("D", restrict(D, live), positive=True)
    return extend((V * evals.log()[..., None, :]) @ V.mT, live)


def exponential(X, null: Bool[Tensor, " m"] | None = None) -> Float[Tensor, "*s m m"]:
    """exp X of symmetric matrices, positive definite: exponential(logarithm(D), null_functions(D)) is D.

    Args:
        X: (…, m, m).
        null: (m,) bool, functions that shall be null in the result. None is none: the exponential of zero is one, and
            a logarithm does not tell a null function from one that the shape leaves as it is.

    Returns:
        (…, m, m) float64.

    Raises:
        InputError: not symmetric.
    """
    X = as_operators("X", X)
    live = torch.ones(X.shape[-1], dtype=torch.bool, device=X.device) if null is None else ~_null(null, X)
    evals, V = symmetric_eigh("X", restrict(X, live))
    return extend((V * evals.exp()[..., None, :]) @ V.mT, live)


def log_eigenvalues(D) -> Float[Tensor, "*s l"]:
    """Logarithms of the eigenvalues, ascending (…, l) float64: what a shape does, in no basis at all.

    Args:
        D: (…, m, m) symmetric, positive definite on its l live functions.

    Raises:
        InputError: as `logarithm`.
    """
    D = as_operators("D", D)
    return symmetric_eigh("D", restrict(D, ~null_functions(D)), positive=True)[0].log()


def _null(null: Tensor | None, D: Tensor) -> Tensor:
    if null is None:
        return null_functions(D)
    null = torch.as_tensor(null, device=D.device)
    if null.dtype != torch.bool or null.shape != D.shape[-1:]:
        raise InputError(f"null: expected a bool for each of {D.shape[-1]} functions, got {tuple(null.shape)}")
    return null
