"""The form edge after edge, against its definition."""

import numpy as np
import pytest
import torch

from lssd_learn.latent.explicit import ExplicitForm
from lssd_learn.latent.graphs import topology

N, K = 7, 3


@pytest.mark.parametrize("kind", ["clique", "hubs", "chain"])
def test_it_is_what_maps_miss_weighted_by_edge_and_direction(kind):
    rng = np.random.default_rng(0)
    edges = {
        "clique": topology.clique(N), "hubs": topology.hubs(rng.normal(size=(N, 2)), 2), "chain": topology.chain(N),
    }[kind]  # fmt: skip
    both = rng.permutation(np.concatenate([edges, edges[:, ::-1]]))
    weights, C = rng.uniform(0.1, 2, len(both)), torch.from_numpy(rng.normal(size=(N, N, K, K)))
    form = ExplicitForm(N, both, weights, lambda i, targets: C[i, list(targets)])
    Y = torch.from_numpy(rng.normal(size=(N, K, 4)))
    missed = [w * (C[i, j] @ Y[i] - Y[j]).square().sum(0) for (i, j), w in zip(both, weights, strict=True)]
    flat = Y.flatten(0, 1)
    torch.testing.assert_close((flat * form.apply(flat)).sum(0), torch.stack(missed).sum(0))
    torch.testing.assert_close(form.dense() @ flat, form.apply(flat))
