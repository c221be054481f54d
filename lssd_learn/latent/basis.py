"""From a network to its latent bases: first consistent, then canonical (the paper's Algorithms 1 and 2)."""

import math
from dataclasses import dataclass

import torch
from torch import Tensor

from lssd_learn.errors import InputError
from lssd_learn.latent.eigen import lowest_eigenpairs
from lssd_learn.latent.forms import ExplicitForm, FactorisedForm

# Up to this size W is diagonalised as a dense matrix.
DENSE_SIZE = 1000
# At least as many eigenvectors are carried beyond those wanted, and k in all: they settle clusters of nearly equal
# eigenvalues at the cut-off. Energies grow fast with frequency, so that a narrower block would converge slowly.
GUARDS = 16


@dataclass(frozen=True)
class ConsistentBasis:
    """Y with C_ij Y_i ≈ Y_j.

    Attributes:
        Y: (n, k, size), Σ Y_iᵀY_i = n·I.
        energy: (size,) what each function costs, ascending: the eigenvalues of the network's form.
    """

    Y: Tensor
    energy: Tensor


def consistent_basis(
    form: ExplicitForm | FactorisedForm, size: int, tolerance: float | None = None, seed: int = 0
) -> ConsistentBasis:
    """The `size` most consistent functions: the lowest eigenvectors of the form (Wang, Huang & Guibas 2013).

    Args:
        form: of a network of n shapes with k functions.
        size: at most k.
        tolerance: on the eigenvectors' residual, relative to the form's norm; None is the form's own.
        seed: of the random part of the start block.

    Raises:
        InputError: size is not in 1 … k.
    """
    n, k = form.n, form.k
    if not 1 <= size <= k:
        raise InputError(f"size={size}: expected 1 to {k}, the number of eigenfunctions a shape")
    if n * k <= DENSE_SIZE:
        energy, X = torch.linalg.eigh(form.dense())
    else:
        start = _start(form, min(max(size + GUARDS, k), n * k), seed)
        tolerance = form.tolerance if tolerance is None else tolerance
        energy, X = lowest_eigenpairs(form.apply, start, size, form.precondition, form.scale, tolerance)
    return ConsistentBasis((math.sqrt(n) * X[:, :size]).reshape(n, k, size), energy[:size])


def _start(form: ExplicitForm | FactorisedForm, width: int, seed: int) -> Tensor:
    """The form's own vectors, and a little noise, which keeps no direction out, to the full width (n·k, width)."""
    generator = torch.Generator().manual_seed(seed)
    start = torch.linalg.qr(form.start(width))[0]
    noise = torch.randn(len(start), width, generator=generator, dtype=torch.float64).to(start)
    noise *= 1e-3 / math.sqrt(len(start))
    noise[:, : start.shape[1]] += start
    return noise


def canonical_basis(Y: Tensor, evals: Tensor) -> tuple[Tensor, Tensor, Tensor]:
    """The rotation of a consistent basis that makes (1/n) Σ YᵀΛY diagonal (Algorithm 1).

    The sign of each function is such that the cubes of its coefficients sum, over all shapes, to a positive number.

    Args:
        Y: (n, k, size), Σ YᵀY = n·I.
        evals: (n, k) Λ.

    Returns:
        Ỹ = Y U (n, k, size), U (size, size) orthogonal, Λ₀ (size,) ascending.
    """
    E = (Y.transpose(1, 2) @ (evals[:, :, None] * Y)).mean(0)
    spectrum, U = torch.linalg.eigh((E + E.T) / 2)
    canonical = Y @ U
    sign = torch.where((canonical**3).sum((0, 1)) < 0, -1.0, 1.0).to(Y)
    return canonical * sign, U * sign, spectrum
