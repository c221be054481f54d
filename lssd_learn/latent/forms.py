"""The energy of a functional map network as a quadratic form on bases Y = (Y_1 … Y_n), in two forms of one interface.

    yᵀ W y = Σ_{i→j} w_ij ‖C_ij y_i − y_j‖²        (Wang, Huang & Guibas 2013)

`ExplicitForm` holds the blocks of W that the edges fill. `FactorisedForm` is for cliques of vertex correspondences:
with C_ij = B_jᵀA_i every sum over pairs is a product of two sums over shapes, so that cost and memory grow with n.
Blocks of functions are stacked: a vector y has n·k entries, shape after shape.
"""

from collections.abc import Callable, Sequence
from functools import cached_property

import numpy as np
import scipy.sparse as sparse
import torch
from scipy.sparse.linalg import splu
from torch import Tensor

from lssd_learn.latent.coarse import CoarseSpace
from lssd_learn.latent.factors import Factors

# W's own scale is about two a neighbour; a shift this far below it makes the inverse exist and hardly changes it.
RELATIVE_SHIFT = 1e-6
# Up to this mean number of neighbours (trees, chains, stars, linked trees) the sparse factor of W hardly fills in.
SPARSE_NEIGHBOURS = 6


class ExplicitForm:
    """W as blocks on the edges of a graph.

    Args:
        n: number of shapes.
        edges: (m, 2) int, directed, i → j, every pair in both directions.
        weights: (m,) float, w_ij.
        maps: i and d numbers j → (d, k, k) the maps C_ij.
    """

    def __init__(self, n: int, edges: np.ndarray, weights: np.ndarray, maps: Callable[[int, Sequence[int]], Tensor]):
        W = sparse.csr_array((weights, (edges[:, 0], edges[:, 1])), shape=(n, n))
        W.sort_indices()
        targets = np.split(W.indices, W.indptr[1:-1])
        out = [maps(i, targets[i].tolist()) for i in range(n)]  # C_ij of every edge i → j
        u = [
            torch.from_numpy(w).to(C)[:, None, None] for w, C in zip(np.split(W.data, W.indptr[1:-1]), out, strict=True)
        ]
        self.n, self.k = n, out[0].shape[2]
        self._laplacian = sparse.csr_array(sparse.csgraph.laplacian((W + W.T) / 2))
        self._laplacian.sort_indices()
        identity = torch.eye(self.k).to(out[0])
        incoming = W.sum(axis=0)

        self.columns, self.rows, diagonal = [], [], []
        for i in range(n):
            own = (u[i] * out[i]).flatten(0, 1).T @ out[i].flatten(0, 1) + incoming[i] * identity
            # The edges come in pairs: where i → j is the p-th of i, j → i is the q-th of j.
            back = [(j, int(np.searchsorted(targets[j], i))) for j in targets[i].tolist()]
            coupling = -(u[i] * out[i]).mT - torch.stack([u[j][q] * out[j][q] for j, q in back])
            place = int(np.searchsorted(targets[i], i))
            row = torch.cat([coupling[:place], own[None], coupling[place:]])
            self.columns.append(torch.from_numpy(np.insert(targets[i], place, i).astype(np.int64)).to(own.device))
            self.rows.append(row.transpose(0, 1).flatten(1))  # (k, d·k)
            diagonal.append(own)
        self.diagonal = torch.stack(diagonal)

    def apply(self, Y: Tensor) -> Tensor:
        """W Y for Y (n·k, m)."""
        pieces = Y.view(self.n, self.k, -1)
        out = [row @ pieces[j].flatten(0, 1) for row, j in zip(self.rows, self.columns, strict=True)]
        return torch.cat(out)

    def dense(self) -> Tensor:
        """W (n·k, n·k)."""
        W = self.diagonal.new_zeros(self.n, self.k, self.n, self.k)
        for i, (row, j) in enumerate(zip(self.rows, self.columns, strict=True)):
            W[i, :, j] = row.view(self.k, len(j), self.k)
        return W.view(self.n * self.k, self.n * self.k)

    @cached_property
    def scale(self) -> float:
        """A measure of W's norm: the largest mean eigenvalue of a diagonal block, doubled."""
        return 2 * float(self.diagonal.diagonal(dim1=1, dim2=2).mean(1).max())

    @cached_property
    def precondition(self) -> Callable[[Tensor], Tensor]:
        """An approximate inverse: the sparse factor where it stays sparse, elsewhere the inverted diagonal blocks and
        a coarse space of what varies slowly over the graph."""
        if self._is_sparse:
            return self._sparse_inverse()
        shift = RELATIVE_SHIFT * self.scale
        near, far = _block_inverse(self.diagonal, shift), self._coarse.inverse(shift)
        return lambda Y: near(Y) + far(Y)

    @cached_property
    def _coarse(self) -> CoarseSpace:
        # For each shape i and each neighbour j, w_ij C_ijᵀ + w_ji C_ji (d, k, k) is nearly a multiple of C_ji.
        blocks = [row.view(self.k, -1, self.k).transpose(0, 1) for row in self.rows]
        transports = [-b[j != i] for i, (b, j) in enumerate(zip(blocks, self.columns, strict=True))]
        return CoarseSpace(self.apply, self._laplacian, transports)

    @property
    def tolerance(self) -> float:
        """How exact eigenvectors have to be: more so than in a clique, whose spectral gaps are large."""
        return 1e-7 if self._is_sparse else 1e-6

    @property
    def _is_sparse(self) -> bool:
        return sum(map(len, self.columns)) / self.n - 1 <= SPARSE_NEIGHBOURS

    def start(self, width: int) -> Tensor:
        """At most `width` vectors (n·k, …) to begin with."""
        if self._is_sparse:  # the low eigenfunctions of every shape, paired by order
            return torch.eye(self.k, min(width, self.k)).to(self.diagonal).repeat(self.n, 1)
        return self._coarse.lowest(width)

    def _sparse_inverse(self) -> Callable[[Tensor], Tensor]:
        data = torch.cat([row.view(self.k, -1, self.k).transpose(0, 1) for row in self.rows]).cpu().numpy()
        indices = torch.cat(self.columns).cpu().numpy()
        indptr = np.concatenate([[0], np.cumsum([len(j) for j in self.columns])])
        size = self.n * self.k
        W = sparse.bsr_matrix((data, indices, indptr), shape=(size, size)).tocsc()
        shifted = W + RELATIVE_SHIFT * self.scale * sparse.identity(size, format="csc")
        factor = splu(shifted, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
        return lambda Y: torch.from_numpy(factor.solve(Y.cpu().numpy())).to(Y)


class FactorisedForm:
    """W of a clique of vertex correspondences, C_ij = B_jᵀ A_i, with weights w_ij = u_i u_j.

    The loops i → i are part of it: C_ii is the identity, they add nothing.

        (W y)_i = u_i [(A_iᵀ G A_i + s I) y_i − A_iᵀ Σ_j u_j B_j y_j − B_iᵀ Σ_j u_j A_j y_j],
        G = Σ_j u_j B_j B_jᵀ,  s = Σ_j u_j

    Args:
        factors: of n shapes, rank r, k functions.
        weights: (n,) u; None is 1.
    """

    tolerance = 1e-5

    def __init__(self, factors: Factors, weights: Tensor | None = None):
        A, B = factors.A, factors.B
        self.n, _, self.k = A.shape
        u = A.new_ones(self.n) if weights is None else torch.as_tensor(weights).to(A)
        self._G = _weighted_gram(B, u)
        self.diagonal = torch.stack([a.T @ (self._G @ a) for a in A])
        self.diagonal.diagonal(dim1=1, dim2=2).add_(u.sum())
        self.diagonal *= u[:, None, None]
        self._A = (u[:, None, None] * A.transpose(1, 2)).flatten(0, 1)  # (n·k, r), rows u_i A_iᵀ
        self._B = (u[:, None, None] * B.transpose(1, 2)).flatten(0, 1)

    def apply(self, Y: Tensor) -> Tensor:
        """W Y for Y (n·k, m)."""
        own = (self.diagonal @ Y.view(self.n, self.k, -1)).flatten(0, 1)
        return own - self._A @ (self._B.T @ Y) - self._B @ (self._A.T @ Y)

    def dense(self) -> Tensor:
        """W (n·k, n·k)."""
        return torch.block_diag(*self.diagonal) - self._A @ self._B.T - self._B @ self._A.T

    @cached_property
    def scale(self) -> float:
        """A measure of W's norm: the largest mean eigenvalue of a diagonal block, doubled."""
        return 2 * float(self.diagonal.diagonal(dim1=1, dim2=2).mean(1).max())

    @cached_property
    def precondition(self) -> Callable[[Tensor], Tensor]:
        """The inverted diagonal blocks: in a clique they are all but the low-rank coupling."""
        return _block_inverse(self.diagonal, 0.0)

    def start(self, width: int) -> Tensor:
        """At most `width` vectors (n·k, …) to begin with: the functions that most eigenbases hold, on each shape.

        Of a common function f = Q p the eigenbases hold Σ_j ‖Φ_jᵀ M_j f‖² = pᵀGp; if that were all of it, f would be
        perfectly consistent.
        """
        return self._B @ torch.linalg.eigh(self._G)[1].flip(1)[:, :width]


def _weighted_gram(B: Tensor, u: Tensor) -> Tensor:
    G = B.new_zeros(B.shape[1], B.shape[1])
    for b, weight in zip(B, u.tolist(), strict=True):
        G.addmm_(b, b.T, alpha=weight)
    return G


def _block_inverse(blocks: Tensor, shift: float) -> Callable[[Tensor], Tensor]:
    n, k, _ = blocks.shape
    identity = torch.eye(k, dtype=blocks.dtype, device=blocks.device)
    inverse = torch.linalg.inv(blocks + shift * identity)
    return lambda Y: (inverse @ Y.view(n, k, -1)).flatten(0, 1)
