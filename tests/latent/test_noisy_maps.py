"""A network whose maps have errors: edges that count less for it, and maps brought back."""

from dataclasses import replace

import numpy as np
import pytest
import torch

from lssd_learn.errors import InputError
from lssd_learn.latent import LatentSpace, MapNetwork
from lssd_learn.maps import from_correspondence


def noisy(bases, level, bad=(), seed=0):
    """(i, j) → the true map and noise, ten times as much of it on the pairs in `bad`."""
    rng = np.random.default_rng(seed)
    n, k = len(bases), bases[0].k
    noise = level * rng.normal(size=(n, n, k, k))
    for i, j in bad:
        noise[[i, j], [j, i]] *= 10
    return lambda i, j: from_correspondence(bases[i], bases[j]) + noise[i, j]


def test_an_edge_whose_maps_do_not_undo_each_other_counts_less(truncated):
    bases = truncated(8, 20)
    maps = noisy(bases, 0.02, bad=[(0, 1), (2, 5)])
    edges = [(i, j) for i in range(8) for j in range(i + 1, 8)]
    network = MapNetwork.from_edges(bases, edges, maps, "cycle")
    weights = dict(zip(edges, network.cycle_weights(), strict=True))
    assert max(weights.pop((0, 1)), weights.pop((2, 5))) < 0.5 * min(weights.values())
    assert max(weights.values()) <= 1
    true = LatentSpace.fit(MapNetwork.from_edges(bases, edges), 12, 8).differences()[0]
    errors = [
        float(
            (torch.linalg.eigvalsh(LatentSpace.fit(net, 12, 8).differences()[0]) - torch.linalg.eigvalsh(true)).norm()
        )
        for net in (network, MapNetwork.from_edges(bases, edges, maps))
    ]
    assert errors[0] < errors[1]


def test_weights_by_cycles_in_every_topology(truncated):
    bases = truncated(6, 10)
    networks = [
        MapNetwork.nearest(bases, 2, weights="cycle"),
        MapNetwork.spanning_tree(bases, weights="cycle"),
        MapNetwork.clusters(bases, list("aaabbb"), weights="cycle"),
        MapNetwork.clique(bases, weights="cycle"),
    ]
    for network in networks:
        weights = network.cycle_weights()
        given = MapNetwork.from_edges(bases, network.pairs(), weights=weights)
        torch.testing.assert_close(network.form().dense(), given.form("explicit").dense())
    with pytest.raises(InputError, match="weights=best: expected cycle, numbers or null"):
        MapNetwork.clique(bases, weights="best")


def test_consistent_zoomout_brings_noisy_maps_back(truncated):
    """Of one body, its eigenfunctions each time with signs of its own: the true map is vertex identity."""
    (basis,), rng = truncated(1, 50), np.random.default_rng(0)
    bases = [replace(basis, evecs=basis.evecs * rng.choice([-1, 1], 50)) for _ in range(5)]
    rough = MapNetwork.chain(bases, noisy(bases, 0.01))
    refined = rough.refine(10, 50, 10)
    pairs = [tuple(pair) for pair in rough.pairs().tolist()]
    assert set(refined.maps.vertices) == {*pairs, *(pair[::-1] for pair in pairs)}
    before, after = [], []
    for i, j in pairs:
        assert np.mean(refined.maps.vertices[i, j] == np.arange(615)) > 0.7
        true = from_correspondence(bases[i], bases[j])
        before.append(np.linalg.norm(rough.map(i, j) - true))
        after.append(np.linalg.norm(refined.map(i, j) - true))
    assert sum(after) < 0.7 * sum(before)
    for changes in ({"first": 1}, {"last": 51}, {"step": 0}, {"first": 40, "last": 30}):
        with pytest.raises(InputError, match="expected a whole number"):
            rough.refine(**changes)
