"""A coarse space for sparse networks: copies of every function that vary slowly over the graph.

Where maps are nearly consistent, W is nearly L ⊗ I, with L the graph's Laplacian, in frames F_i that carry the
functions of one shape to all others. Its low eigenvectors are then ψ_g(i) F_i a, with ψ_g the low eigenvectors of L.
Block diagonal preconditioners know nothing of them: a product with W reaches a neighbour, not the far end of the graph.
Solving on their span as well is what two-level domain decomposition does (Toselli & Widlund 2005, "Domain Decomposition
Methods").
"""

from collections.abc import Callable, Sequence
from typing import cast

import numpy as np
import scipy.linalg
import scipy.sparse as sparse
import torch
from jaxtyping import Float
from scipy.sparse.csgraph import breadth_first_order
from torch import Tensor

from lssd_learn.latent.orthogonal import nearest_orthogonal

MODES = 10  # eigenvectors of the graph that are used, fewer where
LARGEST = 1000  # the coarse problem would have more unknowns than this, or where
SLOW = 0.5  # they oscillate faster than this part of the mean degree: such vectors need no help
CHUNK = 64  # columns a product


class CoarseSpace:
    """Orthonormal P (n·k, p·k) that nearly holds the low eigenvectors of W.

    Args:
        apply: Y → W Y.
        laplacian: L (n, n) of a connected graph, sorted indices.
        transports: for each shape i, (d, k, k): for each neighbour j in the order of row i of `laplacian`, itself left
            out, a multiple of the map that carries functions on j to i.
    """

    def __init__(
        self, apply: Callable[[Tensor], Tensor], laplacian: sparse.csr_array, transports: Sequence[Tensor]
    ) -> None:
        n, k = cast(tuple[int, int], laplacian.shape)[0], transports[0].shape[-1]
        self._frames = _frames(laplacian, transports)
        self._modes = _slow_modes(laplacian, min(n, MODES, max(1, LARGEST // k))).to(self._frames)
        identity = torch.eye(self._modes.shape[1] * k).to(self._frames)
        E = torch.cat([self._down(apply(self._up(columns))) for columns in identity.split(CHUNK, dim=1)], dim=1)
        self._values, self._vectors = torch.linalg.eigh((E + E.T) / 2)  # of PᵀWP

    def lowest(self, width: int) -> Float[Tensor, "nk width"]:
        """The eigenvectors of W within the coarse space (n·k, width), fewer if it has not as many."""
        return self._up(self._vectors[:, :width])

    def inverse(self, shift: float) -> Callable[[Tensor], Tensor]:
        """Y (n·k, m) → P (PᵀWP + shift·I)⁻¹ Pᵀ Y."""
        E = self._vectors / (self._values + shift) @ self._vectors.T
        return lambda Y: self._up(E @ self._down(Y))

    def _up(self, c: Tensor) -> Tensor:
        """P c."""
        n, k, _ = self._frames.shape
        slow = self._modes @ c.reshape(self._modes.shape[1], -1)
        return (self._frames @ slow.view(n, k, -1)).flatten(0, 1)

    def _down(self, Y: Tensor) -> Tensor:
        """Pᵀ Y."""
        n, k, _ = self._frames.shape
        return (self._modes.T @ (self._frames.mT @ Y.reshape(n, k, -1)).flatten(1)).view(-1, Y.shape[1])


def _frames(laplacian: sparse.csr_array, transports: Sequence[Tensor]) -> Tensor:
    """F (n, k, k), orthogonal: the identity on the best connected shape, carried from neighbour to neighbour."""
    root = int(laplacian.diagonal().argmax())
    order, parents = breadth_first_order(laplacian, root, directed=False)
    frames = torch.eye(transports[0].shape[-1]).to(transports[0]).repeat(len(transports), 1, 1)
    for i in order[1:].tolist():
        neighbours = _neighbours(laplacian, i)
        carried = transports[i][int(np.searchsorted(neighbours, parents[i]))] @ frames[parents[i]]
        frames[i] = nearest_orthogonal(carried)  # what truncation loses on the way does not add up
    return frames


def _neighbours(laplacian: sparse.csr_array, i: int) -> np.ndarray:
    row = laplacian.indices[laplacian.indptr[i] : laplacian.indptr[i + 1]]
    return row[row != i]


def _slow_modes(laplacian: sparse.csr_array, most: int) -> Tensor:
    """ψ (n, p): the eigenvectors of the graph below `SLOW`, the constant at least."""
    values, vectors = scipy.linalg.eigh(laplacian.toarray(), subset_by_index=[0, most - 1])
    slow = values <= SLOW * laplacian.diagonal().mean()
    slow[0] = True
    return torch.from_numpy(np.ascontiguousarray(vectors[:, slow]))
