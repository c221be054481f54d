"""A peer's implementation of the same algorithms gives the same latent space."""

from types import SimpleNamespace

import numpy as np
import pytest
import torch

from lssd_learn.latent import LatentSpace, MapNetwork
from lssd_learn.maps import from_correspondence

FMN = pytest.importorskip("pyFM.FMN").FMN  # a peer that only `dev` installs


def peer(bases, edges, k):
    meshes = [SimpleNamespace(eigenvalues=b.evals, eigenvectors=b.evecs) for b in bases]
    both_ways = [(i, j) for a, b in edges for i, j in ((a, b), (b, a))]
    network = FMN(meshes).set_maps({(i, j): from_correspondence(bases[i], bases[j]) for i, j in both_ways})
    network.set_weights(weight_type="adjacency")
    network.compute_W(M=k)
    network.compute_CLB()
    network.compute_CCLB(k, verbose=False)
    return network


def agrees(bases, edges, latent, gauge):
    network = peer(bases, edges, latent.keep)
    np.testing.assert_allclose(
        network.cclb_eigenvalues[1:], latent.spectrum[1:].numpy(), rtol=1e-6, atol=1e-6 * float(latent.spectrum[-1])
    )
    area, conformal = (torch.from_numpy(np.stack(D)) for D in zip(*map(network.get_CSD, range(10)), strict=True))
    ours, ours_conformal = latent.differences()
    s = gauge(ours, area)
    torch.testing.assert_close(s * area, ours, rtol=0, atol=1e-6)
    # The peer divides by the first frequency too, which is rounding: its first row is none of ours.
    torch.testing.assert_close((s * conformal)[:, 1:], ours_conformal[:, 1:], rtol=0, atol=1e-6)


def test_ten_bodies_in_a_clique(truncated, gauge):
    bases = truncated(10, 30)
    edges = [(i, j) for i in range(10) for j in range(i)]
    agrees(bases, edges, LatentSpace.fit(MapNetwork.clique(bases), 30, 30), gauge)


def test_ten_bodies_and_their_nearest_neighbours(truncated, gauge):
    network = MapNetwork.nearest(truncated(10, 30), 4)
    agrees(network.bases, network.edges.tolist(), LatentSpace.fit(network, 30, 30), gauge)
