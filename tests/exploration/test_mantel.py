from itertools import permutations

import numpy as np
import pytest

from lssd_learn.errors import InputError
from lssd_learn.exploration.mantel import distances, mantel

RNG = np.random.default_rng(0)


def test_correlation_of_distances_and_its_chance():
    x = RNG.normal(size=(6, 3))
    y = x + 0.8 * RNG.normal(size=(6, 3))
    a, b = distances(x), distances(y)
    np.testing.assert_allclose(a[1, 4], np.linalg.norm(x[1] - x[4]))
    pairs = np.triu_indices(6, 1)
    every = [np.corrcoef(a[pairs], b[np.ix_(o, o)][pairs])[0, 1] for o in map(list, permutations(range(6)))]
    found = mantel(a, b, 4999)
    assert found.correlation == pytest.approx(every[0])
    assert found.p == pytest.approx(np.mean(np.array(every) >= every[0] - 1e-12), abs=0.02)


def test_shapes_moved_and_turned_are_as_far_apart_as_before():
    x = RNG.normal(size=(9, 2))
    turned = x @ np.array([[0.6, 0.8], [-0.8, 0.6]]) + 3
    assert mantel(distances(x), distances(turned), 99) == (pytest.approx(1), 0.01)


def test_distances_that_say_nothing():
    same = 1 - np.eye(5)
    with pytest.raises(InputError, match="expected some that differ"):
        mantel(same, distances(RNG.normal(size=(5, 2))), 9)
    with pytest.raises(InputError, match="four shapes or more"):
        mantel(np.eye(3), np.eye(3))
