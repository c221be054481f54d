"""One shape on a region and another elsewhere, as one operator."""

import torch
from jaxtyping import Float
from torch import Tensor

from lssd_learn.operators.matrices import (
    as_functions,
    as_like_operators,
    extend,
    null_functions,
    restrict,
    symmetric_eigh,
)


def localise(D_A, D_B, F, symmetric: bool = False) -> Float[Tensor, "*s m m"]:
    """D_A (I − FFᵀ) + D_B FFᵀ: acts like D_B on the region that F lives on, like D_A elsewhere.

    With nothing truncated, area operators commute with FFᵀ and the result is the area operator of the mixed shape. In a
    truncated basis it is not symmetric. The symmetric form agrees with B on the region and with A elsewhere as a
    quadratic form, exactly, and its blocks between the two are the mean of those of A and B, as correlations:

        FᵀXF = FᵀD_B F,  GᵀXG = GᵀD_A G,  FᵀXG = (FᵀD_BF)^½ ½ (K_A + K_B) (GᵀD_AG)^½

    with [F G] orthogonal and K_D = (FᵀDF)^-½ FᵀDG (GᵀDG)^-½. Each K is a contraction, and so is their mean: X is
    positive definite whenever A and B are. It is D if both are D, it is the formula above where that is symmetric, and
    to first order in D − I it is that formula's symmetric part (which itself may be indefinite).

    Null functions, see `matrices.py`, matter to the symmetric form only: they are null in the result, and what stands
    for the region are the live directions at less than 45° from the span of F.

    Args:
        D_A, D_B: (…, m, m), any two that broadcast.
        F: (m, r) orthonormal, see `LatentSpace.region`.
        symmetric: the symmetric form, of symmetric positive definite operators.

    Returns:
        (…, m, m) float64.

    Raises:
        InputError: shapes that do not fit, functions that are not orthonormal; for the symmetric form, operators that
            are not symmetric positive definite.

    Source: "Localized Latent Shape Difference" of the paper, whose sentence has the two regions the other way round.
    """
    A, B = as_like_operators(D_A=D_A, D_B=D_B)
    F = as_functions(F, A)
    if not symmetric:
        return A + (B - A) @ F @ F.T
    live = ~null_functions(A, B)
    A, B = torch.broadcast_tensors(restrict(A, live), restrict(B, live))
    for name, D in (("D_A", A), ("D_B", B)):
        symmetric_eigh(name, D, positive=True)  # only to refuse what is not
    # On the live functions FFᵀ is no longer a projection, but its eigenvectors part them into inside and outside. The
    # complement of F parts them in the same way.
    shares, W = torch.linalg.eigh(F[live] @ F[live].T)
    F, G = W[:, shares > 0.5], W[:, shares <= 0.5]
    inside, outside = F.T @ B @ F, G.T @ A @ G
    K = (_correlation(A, F, G) + _correlation(B, F, G)) / 2
    across = F @ (_power(inside, 0.5) @ K @ _power(outside, 0.5)) @ G.T
    return extend(F @ inside @ F.T + G @ outside @ G.T + across + across.mT, live)


def _correlation(D: Tensor, F: Tensor, G: Tensor) -> Tensor:
    """(…, r, l − r) with singular values below 1."""
    return _power(F.T @ D @ F, -0.5) @ (F.T @ D @ G) @ _power(G.T @ D @ G, -0.5)


def _power(D: Tensor, p: float) -> Tensor:
    evals, V = torch.linalg.eigh(D)
    return (V * evals[..., None, :] ** p) @ V.mT
