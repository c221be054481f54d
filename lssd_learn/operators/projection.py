"""What is left of a shape when its deformation of some functions is suppressed."""

import torch
from jaxtyping import Float
from torch import Tensor

from lssd_learn.operators.matrices import as_functions, as_like_operators, as_operators


def project(D, F) -> Float[Tensor, "*s m m"]:
    """P(F) = D (I − FFᵀ) + FFᵀ, which leaves functions in the span of F as they are and acts like D off it.

    Not symmetric, as D and FFᵀ need not commute; `localise(D, I, F, symmetric=True)` is. Nothing is inverted, so that
    null functions are treated like any other.

    Args:
        D: (…, m, m).
        F: (m, r) orthonormal, or one function (m,) of unit length.

    Returns:
        (…, m, m) float64.

    Raises:
        InputError: shapes that do not fit, functions that are not orthonormal.

    Source: the paper's Eq. (projection), "Projected Latent Shape Differences".
    """
    D = as_operators("D", D)
    F = as_functions(F, D)
    return D + (torch.eye(D.shape[-1]).to(D) - D) @ F @ F.T


def delta_energy(D_i, D_j, F) -> Float[Tensor, "*s"]:
    """tr(FᵀΔᵀΔF) (…), Δ = D_i − D_j: how much nearer two shapes come when F is suppressed.

    Equals ‖D_i − D_j‖² − ‖P_i(F) − P_j(F)‖² in the Frobenius norm.

    Args:
        D_i, D_j: (…, m, m), any two that broadcast.
        F: (m, r) orthonormal, or one function (m,) of unit length.

    Raises:
        InputError: shapes that do not fit, functions that are not orthonormal.

    Source: the paper's Lemma (delta energy), which writes Δ² for symmetric operators; ΔᵀΔ serves conformal ones too.
    """
    D_i, D_j = as_like_operators(D_i=D_i, D_j=D_j)
    return ((D_i - D_j) @ as_functions(F, D_i)).square().sum((-2, -1))
