"""The mathematics of `kernel_machine.py`: Gaussian kernels and their slopes."""

import torch
from jaxtyping import Float, Int
from torch import Tensor


def gaussian(
    x: Float[Tensor, "n r"], centres: Float[Tensor, "c r"], metric: Float[Tensor, "r r"]
) -> Float[Tensor, "n c"]:
    """exp(−½ (x − y)ᵀ M (x − y)) (n, c) of every row of x (n, r) and of centres (c, r); metric M (r, r)."""
    moved = centres @ metric
    across = x @ moved.T
    squares = ((x @ metric) * x).sum(1)[:, None] + (moved * centres).sum(1) - 2 * across
    return torch.exp(-0.5 * squares.clamp(min=0))


def best_weights(
    spectrum: tuple[Float[Tensor, " n"], Float[Tensor, "n n"]],
    noises: Float[Tensor, " noises"],
    target: Float[Tensor, " n"],
    across: Float[Tensor, "m n"],
    wanted: Float[Tensor, " m"],
) -> tuple[Float[Tensor, " n"], Tensor]:
    """Weights w (n,) of (K + νI) w = target, and the position of ν: the noise whose K' w is nearest to what is wanted.

    Args:
        spectrum: eigenvalues (n,), none below zero, and eigenvectors (n, n) of the kernel K of the training shapes.
        noises: the ν to choose from.
        target: (n,).
        across: K' (m, n), the kernel of validation and training shapes.
        wanted: (m,).
    """
    evals, V = spectrum
    candidates = V @ ((V.T @ target)[:, None] / (evals[:, None] + noises))
    best = ((across @ candidates - wanted[:, None]) ** 2).mean(0).argmin()
    return candidates[:, best], best


def rehearsed_noise(
    kernel: Float[Tensor, "n n"],
    noises: Float[Tensor, " noises"],
    target: Float[Tensor, " n"],
    blocks: Int[Tensor, " n"],
) -> Tensor:
    """The position of the noise best on blocks of training shapes, each left out in turn; answers stay within range.

    Args:
        kernel: K of the training shapes.
        noises: the ν to choose from.
        target: (n,).
        blocks: (n,) numbers; two or more differ.
    """
    errors = torch.zeros_like(noises)
    for block in blocks.unique():
        out = blocks == block
        evals, V = torch.linalg.eigh(kernel[~out][:, ~out])
        weights = V @ ((V.T @ target[~out])[:, None] / (evals.clamp(min=0)[:, None] + noises))
        found = (kernel[out][:, ~out] @ weights).clamp(target.min(), target.max())
        errors += ((found - target[out, None]) ** 2).sum(0)
    return errors.argmin()


def slopes(
    kernel: Float[Tensor, "c c"],
    centres: Float[Tensor, "c r"],
    weights: Float[Tensor, " c"],
    metric: Float[Tensor, "r r"],
) -> Float[Tensor, "c r"]:
    """Gradients (c, r) of f(x) = Σ_i w_i exp(−½ (x − y_i)ᵀ M (x − y_i)) at the centres y_i themselves.

    Args:
        kernel: (c, c), `gaussian` of the centres.
        centres: (c, r).
        weights: w (c,).
        metric: M (r, r).
    """
    pull = kernel * weights
    return (pull @ centres - pull.sum(1, keepdim=True) * centres) @ metric
