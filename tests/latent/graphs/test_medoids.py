import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.distance import cdist

from lssd_learn.latent.graphs.medoids import medoids


def plain(points, count):
    """All distances, each time."""
    D, chosen, away = cdist(points, points), [], np.full(len(points), np.inf)
    for _ in range(count):
        totals = np.minimum(D, away).sum(axis=1)
        totals[chosen] = np.inf
        chosen.append(int(totals.argmin()))
        away = np.minimum(away, D[chosen[-1]])
    return chosen


@given(
    points=st.integers(1, 3).flatmap(
        lambda d: st.lists(st.tuples(*[st.integers(0, 5)] * d), min_size=2, max_size=30).map(np.array)
    ),
    count=st.integers(1, 6),
    scale=st.sampled_from([1.0, 2.0**-20, 2.0**20]),
    shift=st.sampled_from([0.0, 1000.0]),
)
@settings(max_examples=200, deadline=None)
def test_they_are_those_of_all_distances(points, count, scale, shift):
    points, count = scale * (points + shift), min(count, len(points) - 1)
    assert medoids(points, count) == plain(points, count)


def test_of_many_few_are_looked_at_again(monkeypatch):
    rng = np.random.default_rng(0)
    points = rng.normal(size=(1500, 6)) * [30, 3, 2, 1, 1, 1]
    looked = []
    import lssd_learn.latent.graphs.medoids as module

    gains = module._gains
    monkeypatch.setattr(module, "_gains", lambda *a: looked.append(len(a[2])) or gains(*a))
    monkeypatch.setattr("lssd_learn.latent.graphs.near.ENTRIES", 1 << 20)
    assert medoids(points, 8) == plain(points, 8)
    assert sum(looked) < 4 * len(points)  # twice all of them, not eight times


def test_of_many_those_of_a_sample_are_nearly_as_near(monkeypatch):
    points = np.random.default_rng(0).normal(size=(1500, 6)) * [30, 3, 2, 1, 1, 1]
    exact = medoids(points, 4)
    monkeypatch.setattr("lssd_learn.latent.graphs.medoids.MANY", 500)
    found = medoids(points, 4)
    assert found == medoids(points, 4)
    assert len(set(found)) == 4
    assert found != exact
    away = [cdist(points, points[chosen]).min(axis=1).mean() for chosen in (found, exact)]
    assert away[0] < 1.05 * away[1]
