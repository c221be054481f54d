"""Consistent ZoomOut: the maps of a whole network made finer together, each through what all of them agree on.

Used by `MapNetwork.refine`.
"""

from collections.abc import Sequence

import numpy as np
import torch

from lssd_learn.errors import check_whole
from lssd_learn.kdtree import cKDTree
from lssd_learn.latent.basis import canonical_basis, consistent_basis
from lssd_learn.maps import from_correspondence
from lssd_learn.progress import track
from lssd_learn.shapes import Eigenbasis


class Refined:
    """(i, j) → C_ij of vertices that correspond in the latent shape.

    Args:
        bases: n eigenbases, all their functions.
        embeddings: n arrays (V_i, m), where each vertex lies in the latent shape.
        pairs: the edges of the network, both directions of which are computed at once.
    """

    def __init__(self, bases: Sequence[Eigenbasis], embeddings: Sequence[np.ndarray], pairs: np.ndarray):
        self._bases = bases
        trees = [cKDTree(embedding) for embedding in embeddings]
        self.vertices = {}
        for i, j in track(pairs.tolist(), "refining the maps"):
            self.vertices[i, j] = trees[i].query(embeddings[j])[1]
            self.vertices[j, i] = trees[j].query(embeddings[i])[1]

    def __call__(self, i: int, j: int) -> np.ndarray:
        return from_correspondence(self._bases[i], self._bases[j], self.vertices[i, j])


def refined_maps(network, first: int, last: int, step: int) -> Refined:
    """The maps of a network after Consistent ZoomOut.

    Again and again the canonical latent basis of k functions says where every vertex lies in the latent shape,
    Φ_i Y_i; nearest vertices there are the map, and its functional map has `step` functions more.

    Args:
        network: with computed maps.
        first: functions of the latent shape to begin with.
        last: to end with.
        step: more a round.

    Raises:
        InputError: numbers out of their range.

    Reference:
        Huang, Ren, Wonka and Ovsjanikov, "Consistent ZoomOut: efficient spectral map synchronization", Computer
        Graphics Forum 39 (2020).
    """
    check_whole("last", last, 2, network.k)
    check_whole("first", first, 2, last)
    check_whole("step", step, 1)
    current, pairs = network, network.pairs()
    for k in (*range(first, last, step), last):
        short = current.truncated(k)
        Y = canonical_basis(consistent_basis(short.form(), k).Y, torch.tensor(short.evals))[0].numpy()
        embeddings = [np.asarray(basis.evecs, dtype=float) @ y for basis, y in zip(short.bases, Y, strict=True)]
        maps = Refined(network.bases, embeddings, pairs)
        current = network.with_maps(maps)
    return maps
