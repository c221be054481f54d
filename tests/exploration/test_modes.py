"""From operators to shapes by a small kernel map."""

import numpy as np
import pytest
import torch

from lssd_learn.errors import InputError
from lssd_learn.exploration.modes import shape_map


@pytest.fixture(scope="module")
def curved():
    """Thirty shapes of 50 vertices that follow two numbers, one of them in a curve; and these numbers."""
    rng = np.random.default_rng(0)
    numbers = rng.uniform(-1, 1, (30, 2))
    ways = rng.normal(size=(3, 50, 3))
    bent = np.stack([numbers[:, 0], np.sin(3 * numbers[:, 1]), np.cos(3 * numbers[:, 1])], axis=1)
    return torch.tensor(numbers), rng.normal(size=(50, 3)) + np.tensordot(bent, ways, 1)


def test_shapes_that_had_no_part_in_it_are_drawn(curved):
    features, vertices = curved
    found = shape_map(features, vertices)
    assert found.error < 0.1 * found.spread
    np.testing.assert_allclose(found.vertices(found.coordinates), vertices, atol=0.05)
    products = np.tensordot(found.modes, found.modes, ((1, 2), (1, 2)))
    np.testing.assert_allclose(products, np.eye(3), atol=1e-6)  # three modes: there are no more


def test_what_is_straight_stays_straight(curved):
    features, _ = curved
    ways = np.random.default_rng(1).normal(size=(2, 20, 3))
    vertices = np.tensordot(features.numpy(), ways, 1)
    found = shape_map(features, vertices)
    assert found.error < 1e-3 * found.spread
    beyond = 3 * found.coordinates[:2]
    expected = found.mean + 3 * (vertices[:2] - found.mean)
    assert np.abs(found.vertices(beyond) - expected).max() < 0.1 * np.abs(expected).max()


def test_features_that_tell_nothing_are_no_better_than_the_mean(curved):
    _, vertices = curved
    nothing = torch.tensor(np.random.default_rng(2).normal(size=(30, 5)))
    found = shape_map(nothing, vertices)
    assert 0.7 < found.error / found.spread < 1.3


def test_few_shapes(curved):
    features, vertices = curved
    found = shape_map(features[:4], vertices[:4])
    assert np.isnan(found.error)
    assert found.modes.shape == (3, 50, 3)
    with pytest.raises(InputError, match="^shapes: expected three or more to move between, got 2"):
        shape_map(features[:2], vertices[:2])
    with pytest.raises(InputError, match="^shapes: expected some that differ"):
        shape_map(features[:3], vertices[[0, 0, 0]])
