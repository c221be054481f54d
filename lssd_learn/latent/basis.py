"""From a network to its latent bases: first consistent, then canonical (the paper's Algorithms 1 and 2)."""

import math
from dataclasses import dataclass

import torch
from jaxtyping import Float
from torch import Tensor

from lssd_learn.errors import InputError
from lssd_learn.latent.explicit import ExplicitForm
from lssd_learn.latent.factorised import FactorisedForm

# Up to this size W is diagonalised as a dense matrix.
DENSE_SIZE = 1000
CHUNK = 256  # shapes at once


@dataclass(frozen=True)
class ConsistentBasis:
    """Y with C_ij Y_i ≈ Y_j.

    Attributes:
        Y: (n, k, size), Σ Y_iᵀY_i = n·I.
        energy: (size,) what each function costs, ascending: the eigenvalues of the network's form.
    """

    Y: Float[Tensor, "n k size"]
    energy: Float[Tensor, " size"]


def consistent_basis(
    form: ExplicitForm | FactorisedForm, size: int, tolerance: float | None = None, seed: int = 0
) -> ConsistentBasis:
    """The `size` most consistent functions: the lowest eigenvectors of the form (Wang, Huang & Guibas 2013).

    Args:
        form: of a network of n shapes with k functions.
        size: at most k.
        tolerance: on the eigenvectors' residual, relative to the form's norm; None is the form's own.
        seed: of the random part of the start block, where there is one.

    Raises:
        InputError: size is not in 1 … k.
    """
    n, k = form.n, form.k
    if not 1 <= size <= k:
        raise InputError(f"size={size}: expected 1 to {k}, the number of eigenfunctions a shape")
    if n * k <= DENSE_SIZE:
        energy, X = torch.linalg.eigh(form.dense())
    else:
        energy, X = form.lowest(size, form.tolerance if tolerance is None else tolerance, seed)
    Y = X[:, :size].reshape(n, k, size)
    return ConsistentBasis(Y.mul_(math.sqrt(n)), energy[:size])  # in place: of many shapes it is large


def canonical_basis(
    Y: Float[Tensor, "n k size"], evals: Float[Tensor, "n k"], overwrite: bool = False
) -> tuple[Float[Tensor, "n k size"], Float[Tensor, "size size"], Float[Tensor, " size"]]:
    """The rotation of a consistent basis that makes (1/n) Σ YᵀΛY diagonal (Algorithm 1).

    The sign of each function is such that the cubes of its coefficients sum, over all shapes, to a positive number.

    Args:
        Y: (n, k, size), Σ YᵀY = n·I.
        evals: (n, k) Λ.
        overwrite: write the result over Y: of many shapes there is no room for both.

    Returns:
        Ỹ = Y U (n, k, size), U (size, size) orthogonal, Λ₀ (size,) ascending.
    """
    n, _, size = Y.shape
    E = Y.new_zeros(size, size)
    for y, frequencies in zip(Y.split(CHUNK), evals.split(CHUNK), strict=True):
        E += (y.mT @ (frequencies[:, :, None] * y)).sum(0) / n
    spectrum, U = torch.linalg.eigh((E + E.T) / 2)
    canonical = Y if overwrite and Y.is_contiguous() else Y.new_empty(Y.shape)
    cubes = Y.new_zeros(size)
    for rotated, y in zip(canonical.split(CHUNK), Y.split(CHUNK), strict=True):
        rotated.copy_(y @ U)
        cubes += (rotated**3).sum((0, 1))
    sign = torch.where(cubes < 0, -1.0, 1.0).to(Y)
    canonical *= sign
    return canonical, U * sign, spectrum
