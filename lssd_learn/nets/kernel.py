"""The mathematics of `kernel_machine.py`: logarithms as vectors, Gaussian kernels and their slopes.

Positive definite matrices are compared by the difference of their logarithms (log-Euclidean geometry: Arsigny,
Fillard, Pennec & Ayache 2006): what two shapes do to areas one after the other then adds up, nearly.
"""

import torch
from torch import Tensor

from lssd_learn.errors import InputError

# Operators come in float32, whose rounding would be all there is to a logarithm below this part of the largest
# eigenvalue; an operator further below zero than WRONG is not rounded but no difference of a shape at all.
SMALLEST, WRONG = 1e-6, 1e-4


def log_vectors(operators: Tensor) -> Tensor:
    """Logarithms of symmetric positive definite matrices, as vectors with the same inner products.

    Args:
        operators: (n, m, m).

    Returns:
        (n, m (m + 1) / 2) float64: the upper triangle, times √2 off the diagonal.

    Raises:
        InputError: a matrix that is not symmetric or not positive.
    """
    operators = operators.double()
    m = operators.shape[-1]
    if operators.numel() == 0:
        return operators.new_zeros(len(operators), m * (m + 1) // 2)
    if (operators - operators.mT).abs().max() > WRONG * operators.abs().max():
        raise InputError("operators: expected symmetric ones, of which logarithms can be taken")
    evals, V = torch.linalg.eigh((operators + operators.mT) / 2)
    largest = evals[:, -1:]
    if (evals < -WRONG * largest).any() or (largest <= 0).any():
        raise InputError("operators: expected positive definite ones, of which logarithms can be taken")
    logs = (V * evals.maximum(SMALLEST * largest).log()[:, None, :]) @ V.mT
    rows, columns = torch.triu_indices(m, m)
    return logs[:, rows, columns] * torch.where(rows == columns, 1.0, 2**0.5).to(logs)


def gaussian(x: Tensor, centres: Tensor, metric: Tensor) -> Tensor:
    """exp(−½ (x − y)ᵀ M (x − y)) (n, c) of every row of x (n, r) and of centres (c, r); metric M (r, r)."""
    moved = centres @ metric
    across = x @ moved.T
    squares = ((x @ metric) * x).sum(1)[:, None] + (moved * centres).sum(1) - 2 * across
    return torch.exp(-0.5 * squares.clamp(min=0))


def slopes(kernel: Tensor, centres: Tensor, weights: Tensor, metric: Tensor) -> Tensor:
    """Gradients (c, r) of f(x) = Σ_i w_i exp(−½ (x − y_i)ᵀ M (x − y_i)) at the centres y_i themselves.

    Args:
        kernel: (c, c), `gaussian` of the centres.
        centres: (c, r).
        weights: w (c,).
        metric: M (r, r).
    """
    pull = kernel * weights
    return (pull @ centres - pull.sum(1, keepdim=True) * centres) @ metric
