import numpy as np
import pytest
import torch

from lssd_learn.learning import ShapeData, split


@pytest.fixture(autouse=True)
def _one_thread():
    before = torch.get_num_threads()
    torch.set_num_threads(1)
    yield
    torch.set_num_threads(before)


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
