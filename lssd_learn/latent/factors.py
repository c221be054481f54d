"""Vertex correspondences of a whole collection in factored form: C_ij = B_jᵀ A_i, so that n² maps are never built.

With one connectivity, C_ij = Φ_jᵀ M_j Φ_i. Write Φ_i ≈ Q A_i in a common basis Q of r functions on the vertices; then
B_j = Qᵀ M_j Φ_j does the rest. Q = identity is exact. For large meshes Q spans the collection's own eigenfunctions:
they are smooth and much alike, so a few hundred functions hold them all.
"""

import logging
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import torch
from torch import Tensor

from lssd_learn.progress import track
from lssd_learn.shapes import Eigenbasis

log = logging.getLogger(__name__)

SKETCHED_SHAPES = 96  # as many shapes, spread over the collection, are looked at to find Q
RANK_PER_FUNCTION = 6  # r = 6 k by default: the operators' eigenvalues are then right to 1e-4


@dataclass(frozen=True)
class Factors:
    """C_ij = B[j].T @ A[i].

    Attributes:
        A: (n, r, k) coefficients of the eigenfunctions in Q.
        B: (n, r, k) products of Q with the eigenfunctions in the measure of each shape.
        lost: the root mean square over the eigenfunctions of what Q misses, relative to their norm.
    """

    A: Tensor
    B: Tensor
    lost: float

    def maps(self, i: int, targets: Sequence[int]) -> Tensor:
        """C_ij (d, k, k) for each j of d targets."""
        return self.B[targets].mT @ self.A[i]


def exact_factors(bases: Sequence[Eigenbasis], device: torch.device | str = "cpu") -> Factors:
    """Factors with Q = identity: r = V. For small meshes, and the oracle of `compressed_factors`."""
    A = torch.stack([_tensor(b.evecs, torch.float64, device) for b in bases])
    M = torch.stack([_tensor(b.mass, torch.float64, device) for b in bases])
    return Factors(A, M[:, :, None] * A, 0.0)


def compressed_factors(
    bases: Sequence[Eigenbasis], rank: int | None = None, seed: int = 0, device: torch.device | str = "cpu"
) -> Factors:
    """Factors with a common basis of `rank` functions, found by a randomised range finder (Halko et al. 2011).

    Every eigenbasis is read twice at most, one at a time. The products run in float32, whose rounding lies far below
    what the compression loses; small dense algebra is float64.

    Args:
        bases: eigenbases of one connectivity, k functions each.
        rank: r, by default `RANK_PER_FUNCTION` · k, at most V and the number of functions there are.
        seed: of the random sketch.
    """
    V, k = bases[0].evecs.shape
    rank = min(RANK_PER_FUNCTION * k if rank is None else rank, V, len(bases) * k)
    generator = torch.Generator(device="cpu").manual_seed(seed)

    chosen = np.unique(np.linspace(0, len(bases) - 1, min(len(bases), SKETCHED_SHAPES)).round().astype(int))
    mean_mass = sum(_tensor(bases[i].mass, torch.float64, device) for i in chosen) / len(chosen)
    sketch = torch.zeros(V, rank, dtype=torch.float32, device=device)
    for i in chosen:
        mixing = torch.randn(k, rank, generator=generator).to(device)
        sketch.addmm_(_tensor(bases[i].evecs, torch.float32, device), mixing)
    # Orthonormal in the measure of the average shape, which is near every shape's own.
    root = mean_mass.sqrt()[:, None]
    Q = torch.linalg.qr(root * sketch.double())[0]
    weighted = (root * Q).float()  # M̄ Q'
    Q = (Q / root).float()  # Q' = M̄^-½ Q

    n = len(bases)
    A = torch.empty(n, rank, k, dtype=torch.float64, device=device)
    B = torch.empty(n, rank, k, dtype=torch.float64, device=device)
    lost = 0.0
    for i, basis in enumerate(track(bases, "compressing the correspondences")):
        Phi = _tensor(basis.evecs, torch.float32, device)
        mass = _tensor(basis.mass, torch.float32, device)[:, None]
        A[i] = weighted.T @ Phi
        B[i] = Q.T @ (mass * Phi)
        norms = mean_mass.float() @ (Phi * Phi)
        lost += float((1 - (A[i] ** 2).sum(0) / norms).clamp(min=0).mean()) / n
    log.info("correspondences compressed to %d of %d functions, %.1e of their norm lost", rank, V, lost**0.5)
    return Factors(A, B, lost**0.5)


def _tensor(array: np.ndarray, dtype: torch.dtype, device: torch.device | str) -> Tensor:
    # A memory-mapped array is read-only, which torch warns about: `array` makes a copy.
    return torch.tensor(np.asarray(array), dtype=dtype, device=device)
