"""Latent space shape differences: what a shape does to areas and to angles, seen from the latent shape."""

import torch
from torch import Tensor

# Frequencies below this part of λ₁ are null: the constant function's own is noise of either sign, not zero.
NULL = 1e-3


def area_difference(Y: Tensor) -> Tensor:
    """D^A = YᵀY (…, m, m), symmetric positive definite; Y (…, k, m)."""
    return Y.transpose(-2, -1) @ Y


def conformal_difference(Y: Tensor, evals: Tensor, spectrum: Tensor, symmetric: bool = False) -> Tensor:
    """D^C = Λ₀⁺ YᵀΛY (…, m, m), or its symmetric form Λ₀^-½ YᵀΛY Λ₀^-½, which has the same eigenvalues.

    The constant is its null direction, so first row and column vanish in the symmetric form; of shapes in several
    pieces, as many as there are.

    Args:
        Y: (…, k, m).
        evals: Λ (…, k).
        spectrum: Λ₀ (m,).
    """
    energy = Y.transpose(-2, -1) @ (evals[..., :, None] * Y)
    # As many functions are null as all shapes have pieces: their frequencies are exactly zero.
    inverse = pseudo_inverse(spectrum, max(1, int((evals == 0).sum(-1).min())))
    if symmetric:
        root = inverse.sqrt()
        return root[:, None] * energy * root
    return inverse[:, None] * energy


def pseudo_inverse(spectrum: Tensor, null: int = 1) -> Tensor:
    """The diagonal of Λ₀⁺ (m,): zero at the first `null` places and wherever the frequency is below a thousandth of the
    next, which is λ₁."""
    inverse = torch.zeros_like(spectrum)
    if len(spectrum) > null:
        live = spectrum > NULL * spectrum[null]
        live[:null] = False
        inverse[live] = 1 / spectrum[live]
    return inverse
