import numpy as np
import pytest
from trained import TINY

from lssd_learn.learning import ShapeData, fit, split


@pytest.fixture(scope="session")
def collection():
    """60 symmetric operators near the identity, and the 3 parameters they depend on linearly."""
    generator = np.random.default_rng(0)
    parameters = generator.random((60, 3))
    directions = generator.normal(size=(3, 10, 10))
    directions = directions + directions.swapaxes(1, 2)
    operators = np.eye(10) + 0.1 * np.einsum("np,pij->nij", parameters - 0.5, directions)
    return operators[:, None], parameters


@pytest.fixture
def data(collection):
    return ShapeData(*collection, split=split(60, 0), seed=0, batch=16)


@pytest.fixture
def train(data, tmp_path):
    """fit with what the tests have in common; `out` is a name."""

    def run(net=TINY, shapes=data, out="run", **options):
        options = {"epochs": 6, "learning_rate": 0.01, "seed": 0} | options
        return fit(net, shapes, out=tmp_path / out, **options)

    return run
