import numpy as np
import pytest

from lssd_learn.errors import InputError
from lssd_learn.exploration.representatives import representatives


def naive(points, count):
    chosen = []
    for _ in range(count):
        ways = {}
        for i in set(range(len(points))) - set(chosen):
            near = points[[*chosen, i]]
            ways[i] = sum(np.linalg.norm(near - p, axis=1).min() for p in points)
        chosen.append(min(ways, key=ways.get))
    return chosen


def test_the_medoid_comes_first_and_others_add_to_it():
    points = np.random.default_rng(0).normal(size=(12, 3))
    assert representatives(points, 4) == naive(points, 4)


def test_one_of_each_cluster():
    points = np.repeat([0.0, 10.0, 30.0], [4, 3, 2])[:, None] + np.random.default_rng(0).normal(size=(9, 1))
    assert {int(np.digitize(i, [4, 7])) for i in representatives(points, 3)} == {0, 1, 2}


def test_operators_are_compared_entry_by_entry_and_few_are_all(random_operators):
    D = random_operators(3, 4)
    assert representatives(D, 2) == representatives(D.flatten(1), 2)
    assert sorted(representatives(D, 9)) == [0, 1, 2]
    with pytest.raises(InputError, match="count=0: expected a whole number, 1 or more"):
        representatives(D, 0)
