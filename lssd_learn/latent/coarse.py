"""A coarse space for sparse networks: copies of every function that vary slowly over the graph.

Where maps are nearly consistent, W is nearly 2 L ⊗ I + I ⊗ diag(e), with L the graph's Laplacian, in frames F_i that
carry the functions of one shape to all others, of which function a costs e_a. Its low eigenvectors are then
ψ_g(i) F_i a, of 2 μ_g + e_a, with ψ_g the low eigenvectors of L and μ_g their eigenvalues. Block diagonal
preconditioners know nothing of them: a product with W reaches a neighbour, not the far end of the graph. Solving on
their span as well is what two-level domain decomposition does (Toselli & Widlund 2005, "Domain Decomposition Methods");
since the energies there are known beforehand, as many of them as help cost no product with W.

Frames carried along a tree are rough. Functions of W's own, as areas differ, are longer on one shape than on another;
a few steps of Jacobi's iteration bring that in.
"""

import math
import warnings
from collections.abc import Callable
from typing import cast

import numpy as np
import scipy.linalg
import scipy.sparse as sparse
import torch
from jaxtyping import Float
from scipy.sparse.csgraph import breadth_first_order
from scipy.sparse.linalg import lobpcg, spilu
from torch import Tensor

from lssd_learn.latent.orthogonal import nearest_orthogonal

MODES = 80  # eigenvectors of the graph that are used, fewer where
SLOW = 0.5  # they oscillate faster than this part of the mean degree: such vectors need no help
SMOOTHING, DAMPING = 3, 0.9  # Jacobi's steps on the frames
DENSE = 1500  # shapes up to which the graph's eigenvectors are computed from a full matrix, exactly
SHIFT, GUARDS, ROUNDS = 1e-4, 6, 30  # of their iteration beyond: relative to the mean degree; vectors more; at most


class CoarseSpace:
    """P (n·k, p·k), its columns ψ_g(i) F_i a, that nearly holds the low eigenvectors of W, PᵀP ≈ I.

    Args:
        apply: Y → W Y.
        near: Y → the inverted diagonal blocks of W, applied to Y.
        laplacian: L (n, n) of a connected graph, sorted indices.
        transport: i and a neighbour j → (k, k), a multiple of the map that carries functions on j to i.
        like: (…, k) a tensor of the kind that is asked for.
    """

    def __init__(
        self,
        apply: Callable[[Tensor], Tensor],
        near: Callable[[Tensor], Tensor],
        laplacian: sparse.csr_array,
        transport: Callable[[int, int], Tensor],
        like: Tensor,
    ) -> None:
        n, k = _size(laplacian), like.shape[-1]
        slowness, modes = _slow_modes(laplacian, min(n, MODES))
        self._modes = modes.to(like)
        cost, Y = _smoothed(_frames(laplacian, transport, torch.eye(k).to(like)).flatten(0, 1), apply, near)
        self._frames = Y.mul_(math.sqrt(n)).view(n, k, k)
        self._values = (2 * slowness.to(like)[:, None] + cost).flatten()  # of W on P, nearly

    def lowest(self, width: int) -> Float[Tensor, "nk width"]:
        """The columns of P of lowest energy (n·k, width), fewer if it has not as many."""
        chosen = torch.argsort(self._values, stable=True)[:width]
        columns = self._values.new_zeros(len(self._values), len(chosen))
        columns[chosen, torch.arange(len(chosen))] = 1
        return self._up(columns)

    def inverse(self, shift: float) -> Callable[[Tensor], Tensor]:
        """Y (n·k, m) → P (E + shift·I)⁻¹ Pᵀ Y, with E the energies of P's columns."""
        scale = 1 / (self._values[:, None] + shift)
        return lambda Y: self._up(self._down(Y).mul_(scale))

    def _up(self, c: Tensor) -> Tensor:
        """P c."""
        n, k, _ = self._frames.shape
        slow = self._modes @ c.reshape(self._modes.shape[1], -1)
        return (self._frames @ slow.view(n, k, -1)).flatten(0, 1)

    def _down(self, Y: Tensor) -> Tensor:
        """Pᵀ Y."""
        n, k, _ = self._frames.shape
        return (self._modes.T @ (self._frames.mT @ Y.reshape(n, k, -1)).flatten(1)).view(-1, Y.shape[1])


def _frames(laplacian: sparse.csr_array, transport: Callable[[int, int], Tensor], identity: Tensor) -> Tensor:
    """F (n, k, k), orthogonal: the identity on the best connected shape, carried from neighbour to neighbour."""
    root = int(laplacian.diagonal().argmax())
    order, parents = breadth_first_order(laplacian, root, directed=False)
    frames = identity.repeat(_size(laplacian), 1, 1)
    for i in order[1:].tolist():
        carried = transport(i, int(parents[i])) @ frames[parents[i]]
        frames[i] = nearest_orthogonal(carried)  # what truncation loses on the way does not add up
    return frames


def _smoothed(Y: Tensor, apply: Callable[[Tensor], Tensor], near: Callable[[Tensor], Tensor]) -> tuple[Tensor, Tensor]:
    """Frames Y (n·k, k) without what oscillates from shape to shape, as orthonormal Ritz vectors; their values (k,)."""
    for _ in range(SMOOTHING):
        Y = Y - DAMPING * near(apply(Y))
    Y = torch.linalg.qr(Y)[0]
    E = Y.T @ apply(Y)
    values, rotation = torch.linalg.eigh((E + E.T) / 2)
    return values.clamp(min=0), Y @ rotation


def _slow_modes(laplacian: sparse.csr_array, most: int) -> tuple[Tensor, Tensor]:
    """μ (p,) and ψ (n, p): the eigenvalues and eigenvectors of the graph below `SLOW`, the constant at least."""
    dense = _size(laplacian) <= DENSE
    values, vectors = _lowest_dense(laplacian, most) if dense else _lowest_sparse(laplacian, most)
    slow = values <= SLOW * laplacian.diagonal().mean()
    slow[0] = True
    return torch.from_numpy(values[slow].clip(min=0)), torch.from_numpy(np.ascontiguousarray(vectors[:, slow]))


def _lowest_dense(laplacian: sparse.csr_array, most: int) -> tuple[np.ndarray, np.ndarray]:
    return scipy.linalg.eigh(laplacian.toarray(), subset_by_index=[0, most - 1])


def _lowest_sparse(laplacian: sparse.csr_array, most: int) -> tuple[np.ndarray, np.ndarray]:
    """The same nearly, which is enough, at a cost that grows with n: LOBPCG with an incomplete factor of the graph."""
    n, degree = _size(laplacian), float(laplacian.diagonal().mean())
    shifted = (laplacian + SHIFT * degree * sparse.eye_array(n)).tocsc()
    factor = spilu(shifted, drop_tol=1e-3, fill_factor=10, permc_spec="MMD_AT_PLUS_A")
    start = np.random.default_rng(0).normal(size=(n, most + GUARDS))
    start[:, 0] = 1
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # of vectors that are not exact after so many rounds
        values, vectors = lobpcg(laplacian, start, M=factor.solve, tol=1e-3 * degree, maxiter=ROUNDS, largest=False)
    order = np.argsort(values)[:most]
    return values[order], vectors[:, order]


def _size(laplacian: sparse.csr_array) -> int:
    return cast(tuple[int, int], laplacian.shape)[0]
