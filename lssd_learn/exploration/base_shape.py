"""What there was before latent shapes, to compare with: a base shape, and the energy of adjoint maps."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import torch
from jaxtyping import Float
from scipy.sparse import coo_array
from scipy.sparse.csgraph import breadth_first_order
from torch import Tensor

from lssd_learn.errors import InputError, check_whole
from lssd_learn.latent import MapNetwork
from lssd_learn.latent.base_shape import BaseShapes
from lssd_learn.latent.graphs import topology


def base_shape_differences(
    network: MapNetwork, base: int, keep: int | None = None, kinds: Sequence[str] = ("area", "conformal")
) -> tuple[Tensor, ...]:
    """Differences of some kinds (n, keep, keep), symmetric, of all shapes j, seen from shape `base`: area C_bjᵀC_bj.

    Only the maps of the network's edges are used: from the base to a shape that is not its neighbour they are composed
    along the fewest edges, and err more with each.

    Args:
        network: n shapes, k functions each.
        base: the shape that all others are compared with.
        keep: lowest functions of the base, 1 to k; None is all.
        kinds: see `stack_differences`.

    Raises:
        InputError: there is no such shape or kind, keep out of range.

    Source: Rustamov et al. 2013; "Compatibility with sparse map networks" in the paper.
    """
    check_whole("base", base, 0, network.n - 1)
    along_edges = network if network.edges is None else replace(network, maps=_Composed(network, base))
    return BaseShapes(along_edges, network.k if keep is None else keep).differences(base, kinds)


def adjoint_energy(network: MapNetwork, Y: Tensor, weights=None) -> Float[Tensor, "m m"]:
    """Σ w_ij (X_ijY_i − Y_j)ᵀ(X_ijY_i − Y_j) (m, m), both directions of each edge; X_ij = C_jiᵀ, the adjoint of C_ji.

    Its largest eigenvectors vary most in the sense of Huang & Ovsjanikov 2017, to cross-check those of `variability.py`
    on the area operators. With nothing truncated both energies have the same eigenvectors (indicators of vertices), in
    an order that need not be the same.

    Args:
        network: n shapes, k functions each. A loop over its edges.
        Y: (n, k, m) `LatentSpace.Y`.
        weights: (n, n) symmetric, such as 1 across groups and −1 within; None is 1.

    Raises:
        InputError: weights of another shape.

    Source: the paper's appendix, "Connection between our Method and the framework of [Huang2017]".
    """
    Y = torch.as_tensor(Y).double()
    weights = torch.ones(network.n, network.n) if weights is None else torch.as_tensor(weights)
    if weights.shape != (network.n, network.n):
        raise InputError(f"weights: expected ({network.n}, {network.n}), got {tuple(weights.shape)}")
    energy = torch.zeros(Y.shape[2], Y.shape[2]).to(Y)
    edges = topology.clique(network.n) if network.edges is None else network.edges
    for a, b in edges.tolist():
        for i, j in ((a, b), (b, a)):
            H = torch.as_tensor(network.map(j, i)).to(Y).T @ Y[i] - Y[j]
            energy += float(weights[i, j]) * (H.T @ H)
    return energy


class _Composed:
    """(base, j) → C_bj along the fewest edges of a network."""

    def __init__(self, network: MapNetwork, base: int):
        rows, columns = network.pairs().T
        graph = coo_array(([1.0] * len(rows), (rows, columns)), shape=(network.n, network.n)).tocsr()
        order, before = breadth_first_order(graph, base, directed=False)
        self._found = {base: np.eye(network.k)}
        for j in order[1:].tolist():
            i = int(before[j])
            self._found[j] = np.asarray(network.map(i, j), dtype=float) @ self._found[i]

    def __call__(self, base: int, j: int) -> np.ndarray:
        return self._found[j]
