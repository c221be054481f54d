"""The same form for a clique of vertex correspondences, whose cost and memory grow with n, not with n².

With C_ij = B_jᵀ A_i and weights w_ij = u_i u_j every sum over pairs is a product of two sums over shapes:

    W = D − U J Uᵀ,   U_i = u_i (A_iᵀ B_iᵀ),   D_i = u_i (A_iᵀ G A_i + s I),   G = Σ_j u_j B_j B_jᵀ,   s = Σ_j u_j,

with J the exchange of the two halves. (The loops i → i are part of it: C_ii is the identity, they add nothing.) From
W y = λ y follows y = (D − λ)⁻¹ U J Uᵀ y: as long as λ is below D, an eigenvector lies in the span of D⁻¹U, D⁻²U, …,
and the further powers hardly count, for consistent functions cost little and D is about the number of shapes. What the
Rayleigh quotient needs on that span are the moments UᵀD⁻ᵖU, sums over shapes of matrices that do not grow with n. So
the shapes are passed through four times, a few at once: for G; for the first two moments, whose span gives rough
vectors D⁻¹U C; for what the further powers D⁻ᵖU C of those have in common; and for the vectors themselves.
"""

import logging
from collections.abc import Iterator

import torch
from jaxtyping import Float
from torch import Tensor

from lssd_learn.latent.eigen import GUARDS, block_inverse, lowest_eigenpairs
from lssd_learn.latent.factors import Factors
from lssd_learn.progress import track

log = logging.getLogger(__name__)

CHUNK = 16  # shapes at once
MANY = 1000  # shapes from which on a pass takes long enough to show how far it is
# Powers of D⁻¹ that are tried, with better C each time: two are enough for four fifths of the functions of a shape,
# four for all of them.
POWERS = (2, 4, 6)
# Directions of the span whose squared length is below this part of the largest are rounding.
NEGLIGIBLE = 1e-13


class FactorisedForm:
    """W of a clique of vertex correspondences, C_ij = B_jᵀ A_i, with weights w_ij = u_i u_j.

    Args:
        factors: of n shapes, rank r, k functions.
        weights: (n,) u; None is 1.
    """

    tolerance = 1e-5

    def __init__(self, factors: Factors, weights: Float[Tensor, " n"] | None = None):
        self.n, self._rank, self.k = factors.A.shape
        self._factors = factors
        u = torch.ones(self.n) if weights is None else torch.as_tensor(weights)
        self._u = u.to(factors.A.device, torch.float64)
        self._G = torch.zeros(self._rank, self._rank, dtype=torch.float64, device=self._u.device)
        for few in self._few("network: sums over all shapes"):
            B = factors.B[few].double().transpose(0, 1)  # (r, c, k)
            self._G.addmm_((B * self._u[few, None]).flatten(1), B.flatten(1).T)

    def lowest(
        self, size: int, tolerance: float, seed: int = 0
    ) -> tuple[Float[Tensor, " size"], Float[Tensor, "nk size"]]:
        """The `size` lowest eigenpairs: eigenvalues, ascending, and orthonormal vectors (n·k, size).

        Args:
            size: 1 … k.
            tolerance: on the residuals, relative to the form's norm.
            seed: not needed here; nothing is random.
        """
        width = min(max(size + GUARDS, self.k), 2 * self._rank, self.n * self.k)
        first, second = self._moments()
        form = first - first.T @ self._exchanged(first)
        C = _ritz(second, form, width)[1]
        for powers in POWERS:
            values, parts, coupling = self._refined(first, second, C, powers)
            X, residual = self._vectors(values[:size], [c[:, :size] for c in parts], coupling[:, :size])
            if residual <= tolerance:
                return values[:size], X
            log.debug("consistent basis: residual %.1e with %d powers, wanted %.1e", residual, powers, tolerance)
            C = coupling  # an eigenvector's own
        # Weights of several sizes, or a tolerance below what moments can resolve: go on from there, all in memory.
        X, _ = self._vectors(values, parts, coupling)
        diagonal = torch.cat([D for _, _, D in self._blocks()])
        scale = 2 * float(diagonal.diagonal(dim1=1, dim2=2).mean(1).max())
        values, X = lowest_eigenpairs(
            lambda Y: self._apply(diagonal, Y), X, size, block_inverse(diagonal), scale, tolerance
        )
        return values[:size], X[:, :size]

    def dense(self) -> Float[Tensor, "nk nk"]:
        """W (n·k, n·k)."""
        _, U, D = zip(*self._blocks(), strict=True)
        U = torch.cat(U).flatten(0, 1)
        return torch.block_diag(*torch.cat(D)) - U @ self._exchanged(U.T)

    def _few(self, what: str = "") -> Iterator[slice]:
        """A few shapes at a time; `what` is said of a long pass."""
        few = [slice(start, min(start + CHUNK, self.n)) for start in range(0, self.n, CHUNK)]
        return track(few, what) if what and self.n >= MANY else iter(few)

    def _blocks(self, what: str = "") -> Iterator[tuple[slice, Tensor, Tensor]]:
        """Of a few shapes at a time, which they are, their U_i (c, k, 2r) and D_i (c, k, k)."""
        total = self._u.sum() * torch.eye(self.k).to(self._u)
        for few in self._few(what):
            A, B = self._factors.A[few].double(), self._factors.B[few].double()
            u = self._u[few, None, None]
            yield few, u * torch.cat([A, B], dim=1).mT, u * (A.mT @ (self._G @ A) + total)

    def _exchanged(self, c: Tensor) -> Tensor:
        """J c, the halves of the rows (2r, …) exchanged."""
        return c.roll(self._rank, 0)

    def _moments(self) -> tuple[Tensor, Tensor]:
        """UᵀD⁻¹U and UᵀD⁻²U (2r, 2r)."""
        first, second = (self._G.new_zeros(2 * self._rank, 2 * self._rank) for _ in range(2))
        for _, U, D in self._blocks("consistent basis: moments"):
            solved = torch.cholesky_solve(U, torch.linalg.cholesky(D)).flatten(0, 1)
            first.addmm_(U.flatten(0, 1).T, solved)
            second.addmm_(solved.T, solved)
        return first, second

    def _refined(self, first: Tensor, second: Tensor, C: Tensor, powers: int) -> tuple[Tensor, list[Tensor], Tensor]:
        """Ritz pairs of W on the span of D⁻¹U and of V_p = D⁻ᵖ U C, p = 2 … powers.

        Args:
            first, second: moments, see `_moments`.
            C: (2r, b).

        Returns:
            b values, ascending; what their vectors X = Σ_p D⁻ᵖ U c_p are made of, each c_p (2r, b); and J UᵀX (2r, b).
        """
        across = [first @ C, second @ C]  # UᵀV_p, p = 1 … powers + 1
        across += [torch.zeros_like(C) for _ in range(powers - 1)]
        within = [C.T @ known for known in across[:2]]  # V_aᵀV_b = CᵀUᵀD⁻ᵖUC, p = a + b = 1 … 2 powers
        within += [C.new_zeros(C.shape[1], C.shape[1]) for _ in range(2 * powers - 2)]
        for _, U, D in self._blocks("consistent basis: further powers"):
            factor, V = torch.linalg.cholesky(D), [U @ C]
            for _ in range(powers + 1):
                V.append(torch.cholesky_solve(V[-1], factor))
            V, U = [v.flatten(0, 1) for v in V], U.flatten(0, 1)
            for p in range(3, powers + 2):
                across[p - 1].addmm_(U.T, V[p])
            for p in range(3, 2 * powers + 1):
                within[p - 1].addmm_(V[p // 2].T, V[p - p // 2])
        more = range(2, powers + 1)
        gram = _joined(second, [across[p] for p in more], [[within[p + q - 1] for q in more] for p in more])
        form = _joined(first, [across[p - 1] for p in more], [[within[p + q - 2] for q in more] for p in more])
        UtX = torch.cat([first, *(across[p - 1] for p in more)], dim=1)
        values, Z = _ritz(gram, form - UtX.T @ self._exchanged(UtX), C.shape[1])
        parts = [Z[: len(C)], *(C @ z for z in Z[len(C) :].split(C.shape[1]))]
        return values, parts, self._exchanged(UtX @ Z)

    def _vectors(self, values: Tensor, parts: list[Tensor], coupling: Tensor) -> tuple[Tensor, float]:
        """X = Σ_p D⁻ᵖ U c_p (n·k, m), and the largest ‖W x − λ x‖ relative to the form's norm; see `_refined`."""
        X = self._G.new_empty(self.n, self.k, len(values))
        squares, scale = torch.zeros_like(values), 0.0
        for few, U, D in self._blocks("consistent basis: vectors"):
            factor, x = torch.linalg.cholesky(D), 0
            for c in reversed(parts):
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


def _joined(corner: Tensor, side: list[Tensor], rest: list[list[Tensor]]) -> Tensor:
    """The symmetric matrix of these blocks."""
    wide = torch.cat(side, dim=1)
    return torch.cat(
        [torch.cat([corner, wide], dim=1), torch.cat([wide.T, torch.cat([torch.cat(r, 1) for r in rest])], 1)]
    )


def _ritz(gram: Tensor, form: Tensor, width: int) -> tuple[Tensor, Tensor]:
    """The `width` lowest eigenpairs, fewer where there are not as many, of a form on vectors with this Gram matrix."""
    lengths = gram.diagonal().clamp(min=torch.finfo(gram.dtype).tiny).rsqrt()
    squares, V = torch.linalg.eigh(lengths[:, None] * gram * lengths)
    sound = squares > NEGLIGIBLE * squares[-1]
    V = lengths[:, None] * V[:, sound] / squares[sound].sqrt()
    form = V.T @ form @ V
    values, Z = torch.linalg.eigh((form + form.T) / 2)
    return values[:width], V @ Z[:, :width]
