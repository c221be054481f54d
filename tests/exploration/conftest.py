from functools import cache

import numpy as np
import pytest
import torch

from lssd_learn.collections import Bodies
from lssd_learn.collections.generated.body.poses import POSE_NAMES
from lssd_learn.latent import LatentSpace, MapNetwork
from lssd_learn.shapes import Eigenbasis, eigenbasis


@pytest.fixture(scope="session")
def random_operators():
    """A function (n, m, seed) → n operators (m, m), not symmetric."""
    return lambda n, m, seed=0: torch.from_numpy(np.random.default_rng(seed).normal(size=(n, m, m)))


@pytest.fixture(scope="session")
def two_groups():
    """A function (parameter) → twenty posed bodies, ten with little and ten with much of one parameter.

    The others are random within a quarter of their range. What the tests assert holds for seeds 0 to 3.

    Returns:
        The latent space, the groups, and (V,) how far the parameter moves each vertex, in metres.
    """

    @cache
    def make(parameter, seed=0):
        bodies, rng = Bodies(n=1, topology="notoes_collapse5pc"), np.random.default_rng(seed)
        parameters = rng.uniform(0.375, 0.625, (20, 12))
        parameters[:, bodies.parameter_names.index(parameter)] = np.repeat([0, 0.8], 10) + 0.2 * rng.random(20)
        bases = [eigenbasis(bodies.make(p, POSE_NAMES[i % 8]), 60) for i, p in enumerate(parameters)]
        little, much = (bodies.make({parameter: value}).vertices for value in (0, 1))
        latent = LatentSpace.fit(MapNetwork.clique(bases), 48, 36)
        return latent, ["little"] * 10 + ["much"] * 10, np.linalg.norm(much - little, axis=1)

    return make


@pytest.fixture(scope="session")
def untruncated_bases():
    """A function (n, V, seed) → n eigenbases with as many functions as vertices, of random masses and energies."""

    def make(n, V, seed=0):
        rng = np.random.default_rng(seed)
        bases = []
        for _ in range(n):
            M = rng.uniform(0.5, 2, V)
            evecs = np.linalg.qr(rng.normal(size=(V, V)))[0] / np.sqrt(M)[:, None]
            bases.append(Eigenbasis(np.sort(rng.uniform(1, 50, V)), evecs, M, "one"))
        return bases

    return make
