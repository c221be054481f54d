"""The energy of a functional map network as a quadratic form on bases Y = (Y_1 … Y_n), edge after edge.

    yᵀ W y = Σ_{i→j} w_ij ‖C_ij y_i − y_j‖²        (Wang, Huang & Guibas 2013)

W is held as the blocks that the edges fill. Blocks of functions are stacked: a vector y has n·k entries, shape after
shape. For a clique of vertex correspondences `factorised.py` knows the same form at a cost that grows with n.
"""

import math
from collections.abc import Callable, Sequence
from functools import cached_property

import numpy as np
import scipy.sparse as sparse
import torch
from jaxtyping import Float, Int
from scipy.sparse.linalg import splu
from torch import Tensor

from lssd_learn.latent.coarse import CoarseSpace
from lssd_learn.latent.eigen import GUARDS, block_inverse, lowest_eigenpairs

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

    def __init__(
        self,
        n: int,
        edges: Int[np.ndarray, "m 2"],
        weights: Float[np.ndarray, " m"],
        maps: Callable[[int, Sequence[int]], Tensor],
    ):
        W = sparse.csr_array((weights, (edges[:, 0], edges[:, 1])), shape=(n, n))
        W.sort_indices()
        back_W = sparse.csr_array(W.T)  # of the same pattern: w_ji where W has w_ij
        back_W.sort_indices()
        targets = np.split(W.indices, W.indptr[1:-1])
        # W_ij is the transpose of W_ji: the maps of a pair are asked for once, and let go when its blocks are there.
        # The blocks of shape i lie side by side in rows[i], its own among them where its number falls.
        places = [int(np.searchsorted(j, i)) for i, j in enumerate(targets)]
        like = maps(0, targets[0][:1].tolist())
        self.n, self.k = n, like.shape[2]
        identity = torch.eye(self.k).to(like)
        self.diagonal = torch.from_numpy(W.sum(axis=0)).to(like)[:, None, None] * identity
        self.columns, self.rows = [], [like.new_empty(self.k, len(j) + 1, self.k) for j in targets]
        for i in range(n):
            above = targets[i][places[i] :].tolist()  # j > i
            if above:
                out, back = maps(i, above), torch.cat([maps(j, [i]) for j in above])  # C_ij, C_ji
                some = slice(W.indptr[i] + places[i], W.indptr[i + 1])
                u, v = (torch.from_numpy(w.data[some]).to(like)[:, None, None] for w in (W, back_W))
                self.diagonal[i] += (u * out).flatten(0, 1).T @ out.flatten(0, 1)
                self.diagonal[above] += (v * back).mT @ back
                for j, block in zip(above, -(u * out).mT - v * back, strict=True):
                    at_i, at_j = int(np.searchsorted(targets[i], j)) + 1, int(np.searchsorted(targets[j], i))
                    self.rows[i][:, at_i], self.rows[j][:, at_j] = block, block.T
        for i, place in enumerate(places):
            self.rows[i][:, place] = self.diagonal[i]
            column = torch.from_numpy(np.insert(targets[i], place, i).astype(np.int64))
            self.columns.append(column.to(self.diagonal.device))
        self.rows = [row.flatten(1) for row in self.rows]  # (k, d·k)
        # Neighbours one after another: what is read of them is still in the processor's cache (Cuthill & McKee 1969).
        self._order = sparse.csgraph.reverse_cuthill_mckee(W, symmetric_mode=True).tolist()
        self._laplacian = sparse.csr_array(sparse.csgraph.laplacian((W + W.T) / 2))
        self._laplacian.sort_indices()

    def apply(self, Y: Float[Tensor, "nk m"]) -> Float[Tensor, "nk m"]:
        """W Y for Y (n·k, m)."""
        pieces = Y.view(self.n, self.k, -1)
        out = torch.empty_like(pieces)
        for i in self._order:
            torch.mm(self.rows[i], pieces[self.columns[i]].flatten(0, 1), out=out[i])
        return out.flatten(0, 1)

    def lowest(
        self, size: int, tolerance: float, seed: int = 0
    ) -> tuple[Float[Tensor, " size"], Float[Tensor, "nk size"]]:
        """The `size` lowest eigenpairs: eigenvalues, ascending, and orthonormal vectors (n·k, size).

        Args:
            size: 1 … k.
            tolerance: on the residuals, relative to the form's norm.
            seed: of the random part of the start block.
        """
        start = self._start(min(max(size + GUARDS, self.k), self.n * self.k), seed)
        values, X = lowest_eigenpairs(self.apply, start, size, self.precondition, self.scale, tolerance)
        return values[:size], X[:, :size]

    def dense(self) -> Float[Tensor, "nk nk"]:
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
        far = self._coarse.inverse(RELATIVE_SHIFT * self.scale)
        return lambda Y: self._near(Y).add_(far(Y))

    @cached_property
    def _near(self) -> Callable[[Tensor], Tensor]:
        return block_inverse(self.diagonal, RELATIVE_SHIFT * self.scale)

    @cached_property
    def _coarse(self) -> CoarseSpace:
        return CoarseSpace(self.apply, self._near, self._laplacian, self._transport, self.diagonal)

    def _transport(self, i: int, j: int) -> Tensor:
        """w_ij C_ijᵀ + w_ji C_ji (k, k), which is nearly a multiple of C_ji, for a neighbour j of i."""
        place = int(torch.searchsorted(self.columns[i], j))
        return -self.rows[i].view(self.k, -1, self.k)[:, place]

    @property
    def tolerance(self) -> float:
        """How exact eigenvectors have to be: more so than in a clique, whose spectral gaps are large."""
        return 1e-7 if self._is_sparse else 1e-6

    @property
    def _is_sparse(self) -> bool:
        return sum(map(len, self.columns)) / self.n - 1 <= SPARSE_NEIGHBOURS

    def _start(self, width: int, seed: int) -> Tensor:
        """`width` vectors (n·k, width) to begin with, and a little noise, which keeps no direction out."""
        if self._is_sparse:  # the low eigenfunctions of every shape, paired by order
            start = torch.eye(self.k, min(width, self.k)).to(self.diagonal).repeat(self.n, 1)
        else:
            start = self._coarse.lowest(width)
        start = torch.linalg.qr(start)[0]
        noise = torch.randn(len(start), width, generator=torch.Generator().manual_seed(seed), dtype=torch.float64)
        noise = noise.to(start) * 1e-3 / math.sqrt(len(start))
        noise[:, : start.shape[1]] += start
        return noise

    def _sparse_inverse(self) -> Callable[[Tensor], Tensor]:
        data = torch.cat([row.view(self.k, -1, self.k).transpose(0, 1) for row in self.rows]).cpu().numpy()
        indices = torch.cat(self.columns).cpu().numpy()
        indptr = np.concatenate([[0], np.cumsum([len(j) for j in self.columns])])
        size = self.n * self.k
        W = sparse.bsr_matrix((data, indices, indptr), shape=(size, size)).tocsc()
        shifted = W + RELATIVE_SHIFT * self.scale * sparse.identity(size, format="csc")
        factor = splu(shifted, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
        return lambda Y: torch.from_numpy(factor.solve(Y.cpu().numpy())).to(Y)
