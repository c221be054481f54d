"""The same form for a clique of vertex correspondences, whose cost and memory grow with n, not with n².

With C_ij = B_jᵀ A_i and weights w_ij = u_i u_j every sum over pairs is a product of two sums over shapes:

    W = D − U J Uᵀ,   U_i = u_i (A_iᵀ B_iᵀ),   D_i = u_i (A_iᵀ G A_i + s I),   G = Σ_j u_j B_j B_jᵀ,   s = Σ_j u_j,

with J the exchange of the two halves. (The loops i → i are part of it: C_ii is the identity, they add nothing.) From
W y = λ y follows y = (D − λ)⁻¹ U J Uᵀ y: as long as λ is below D, an eigenvector lies in the span of D⁻¹U, D⁻²U, …,
and the further powers hardly count, for consistent functions cost little and D is about the number of shapes. What the
Rayleigh quotient needs on that span are the moments Uᵀ D⁻ᵖ U, sums over shapes of matrices that do not grow with n. So
the shapes are passed through twice, a few at a time: once for the moments, once for the vectors.
"""

import logging
from collections.abc import Iterator

import torch
from torch import Tensor

from lssd_learn.latent.eigen import GUARDS, block_inverse, lowest_eigenpairs
from lssd_learn.latent.factors import Factors

log = logging.getLogger(__name__)

CHUNK = 16  # shapes at once
# Powers of D⁻¹ that are tried one after the other. Two are enough for four fifths of the functions of a shape.
POWERS = (2, 3)
# Directions of the span whose squared length is below this part of the largest are rounding.
NEGLIGIBLE = 1e-13


class FactorisedForm:
    """W of a clique of vertex correspondences, C_ij = B_jᵀ A_i, with weights w_ij = u_i u_j.

    Args:
        factors: of n shapes, rank r, k functions.
        weights: (n,) u; None is 1.
    """

    tolerance = 1e-5

    def __init__(self, factors: Factors, weights: Tensor | None = None):
        self.n, self._rank, self.k = factors.A.shape
        self._factors = factors
        u = torch.ones(self.n) if weights is None else torch.as_tensor(weights)
        self._u = u.to(factors.A.device, torch.float64)
        self._G = torch.zeros(self._rank, self._rank, dtype=torch.float64, device=self._u.device)
        for few in self._few():
            B = factors.B[few].double().transpose(0, 1)  # (r, c, k)
            self._G.addmm_((B * self._u[few, None]).flatten(1), B.flatten(1).T)

    def lowest(self, size: int, tolerance: float, seed: int = 0) -> tuple[Tensor, Tensor]:
        """The `size` lowest eigenpairs: eigenvalues, ascending, and orthonormal vectors (n·k, size).

        Args:
            size: 1 … k.
            tolerance: on the residuals, relative to the form's norm.
            seed: not needed here; nothing is random.
        """
        width = min(max(size + GUARDS, self.k), 2 * self._rank, self.n * self.k)
        moments = []
        for powers in POWERS:
            moments += self._moments(len(moments), 2 * powers)
            values, C = self._ritz(moments, powers, width)
            X, residual = self._vectors(values[:size], C[:, :, :size], moments)
            if residual <= tolerance:
                return values[:size], X
            log.info("consistent basis: residual %.1e with %d powers, wanted %.1e", residual, powers, tolerance)
        # Weights of several sizes, or a tolerance below what moments can resolve: go on from there, all in memory.
        X, _ = self._vectors(values, C, moments)
        diagonal = torch.cat([D for _, _, D in self._blocks()])
        scale = 2 * float(diagonal.diagonal(dim1=1, dim2=2).mean(1).max())
        values, X = lowest_eigenpairs(
            lambda Y: self._apply(diagonal, Y), X, size, block_inverse(diagonal), scale, tolerance
        )
        return values[:size], X[:, :size]

    def dense(self) -> Tensor:
        """W (n·k, n·k)."""
        _, U, D = zip(*self._blocks(), strict=True)
        U = torch.cat(U).flatten(0, 1)
        return torch.block_diag(*torch.cat(D)) - U @ self._exchanged(U.T)

    def _few(self) -> Iterator[slice]:
        return (slice(start, min(start + CHUNK, self.n)) for start in range(0, self.n, CHUNK))

    def _blocks(self) -> Iterator[tuple[slice, Tensor, Tensor]]:
        """Of a few shapes at a time, which they are, their U_i (c, k, 2r) and D_i (c, k, k)."""
        total = self._u.sum() * torch.eye(self.k).to(self._u)
        for few in self._few():
            A, B = self._factors.A[few].double(), self._factors.B[few].double()
            u = self._u[few, None, None]
            yield few, u * torch.cat([A, B], dim=1).mT, u * (A.mT @ (self._G @ A) + total)

    def _exchanged(self, c: Tensor) -> Tensor:
        """J c, the halves of the rows (2r, …) exchanged."""
        return c.roll(self._rank, 0)

    def _moments(self, known: int, last: int) -> list[Tensor]:
        """Uᵀ D⁻ᵖ U (2r, 2r) for p = known + 1 … last, in one pass."""
        moments = [self._G.new_zeros(2 * self._rank, 2 * self._rank) for _ in range(known, last)]
        for _, U, D in self._blocks():
            factor = torch.linalg.cholesky(D)
            powers = [U]  # D⁻ᵖ U
            for _ in range((last + 1) // 2):
                powers.append(torch.cholesky_solve(powers[-1], factor))
            powers = [power.flatten(0, 1) for power in powers]
            for p, moment in enumerate(moments, start=known + 1):
                moment.addmm_(powers[p // 2].T, powers[p - p // 2])
        return moments

    def _ritz(self, moments: list[Tensor], powers: int, width: int) -> tuple[Tensor, Tensor]:
        """The lowest Ritz values (≤ width,) of W on the span of D⁻ᵖ U, p = 1 … powers, and what their vectors are made
        of: Σ_p D⁻ᵖ U C[p − 1], C (powers, 2r, ≤ width)."""
        orders = range(1, powers + 1)
        gram = torch.cat([torch.cat([moments[p + q - 1] for q in orders], dim=1) for p in orders])
        UtX = torch.cat([moments[p - 1] for p in orders], dim=1)  # (2r, powers · 2r)
        form = torch.cat([torch.cat([moments[p + q - 2] for q in orders], dim=1) for p in orders])
        form -= UtX.T @ self._exchanged(UtX)
        lengths = gram.diagonal().clamp(min=torch.finfo(gram.dtype).tiny).rsqrt()
        squares, V = torch.linalg.eigh(lengths[:, None] * gram * lengths)
        sound = squares > NEGLIGIBLE * squares[-1]
        V = lengths[:, None] * V[:, sound] / squares[sound].sqrt()
        form = V.T @ form @ V
        values, Z = torch.linalg.eigh((form + form.T) / 2)
        return values[:width], (V @ Z[:, :width]).view(powers, 2 * self._rank, -1)

    def _vectors(self, values: Tensor, C: Tensor, moments: list[Tensor]) -> tuple[Tensor, float]:
        """X = Σ_p D⁻ᵖ U C_p (n·k, m), and the largest ‖W x − λ x‖ relative to the form's norm."""
        coupling = self._exchanged(sum(moment @ c for moment, c in zip(moments, C, strict=False)))  # J Uᵀ X
        X = self._G.new_empty(self.n, self.k, C.shape[2])
        squares, scale = torch.zeros_like(values), 0.0
        for few, U, D in self._blocks():
            factor, x = torch.linalg.cholesky(D), 0
            for c in C.flip(0):
                x = torch.cholesky_solve(x + U @ c, factor)
            X[few] = x
            squares += (D @ x - U @ coupling - x * values).square().sum((0, 1))
            scale = max(scale, 2 * float(D.diagonal(dim1=1, dim2=2).mean(1).max()))
        return X.flatten(0, 1), float(squares.max().sqrt()) / scale

    def _apply(self, diagonal: Tensor, Y: Tensor) -> Tensor:
        """W Y for Y (n·k, m)."""
        coupled = Y.new_zeros(2 * self._rank, Y.shape[1])
        pieces = Y.view(self.n, self.k, -1)
        for few, U, _ in self._blocks():
            coupled += U.flatten(0, 1).T @ pieces[few].flatten(0, 1)
        coupled = self._exchanged(coupled)
        return torch.cat([diagonal[few] @ pieces[few] - U @ coupled for few, U, _ in self._blocks()]).flatten(0, 1)
