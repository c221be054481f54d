"""One shape on a region and another elsewhere, by degrees: `localisation.py` for regions that are no projection."""

import torch
from jaxtyping import Float
from torch import Tensor

from lssd_learn.errors import InputError
from lssd_learn.operators.logarithms import exponential, logarithm
from lssd_learn.operators.matrices import WRONG, as_float64, as_like_operators, null_functions


def blend(D_A, D_B, R) -> Float[Tensor, "*s m m"]:
    """exp(log D_A + ½ (R Δ + Δ R)), Δ = log D_B − log D_A: A where R is nothing, B where it is the identity.

    With nothing truncated R is the restriction to the region, a projection that commutes with area operators, and this
    is the area operator of the mixed shape, as `localise` is. In a truncated basis the functions at the border of the
    region belong to it in part: R = FFᵀ gives each wholly to one side, `Region.operator` shares it out.

    Args:
        D_A, D_B: (…, m, m) symmetric positive definite, any two that broadcast; null functions stay null.
        R: (m, m) symmetric.

    Returns:
        (…, m, m) float64, symmetric positive definite; blend(D_A, D_B, R) is blend(D_B, D_A, I − R).

    Raises:
        InputError: shapes that do not fit, R that is not symmetric; operators that are not positive definite.

    Source: of our own, after "Localized Latent Shape Difference" in the paper.
    """
    A, B = as_like_operators(D_A=D_A, D_B=D_B)
    R = as_float64(R).to(A)
    if R.shape != A.shape[-2:] or not ((R - R.T).abs() <= WRONG).all():
        raise InputError(f"R: expected a symmetric matrix of {A.shape[-1]} functions, got {tuple(R.shape)}")
    null = null_functions(A, B)
    log_A, log_B = torch.broadcast_tensors(logarithm(A, null), logarithm(B, null))
    half = R @ (log_B - log_A) / 2
    mixed = log_A + half + half.mT
    mixed[..., null, :] = 0
    mixed[..., :, null] = 0
    return exponential(mixed, null)
