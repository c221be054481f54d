import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import spearmanr

from lssd_learn.errors import InputError
from lssd_learn.exploration.scores import area_under_curve, correlation, rank_correlation, strongest


@given(st.lists(st.tuples(st.integers(-3, 3), st.booleans()), min_size=2, max_size=20))
def test_it_is_the_share_of_pairs_that_are_in_order(vertices):
    field, positive = (np.array(column) for column in zip(*vertices, strict=True))
    if positive.all() or not positive.any():
        with pytest.raises(InputError, match="positive: expected some"):
            area_under_curve(field, positive)
        return
    pairs = [np.sign(a - b) / 2 + 0.5 for a in field[positive] for b in field[~positive]]
    assert area_under_curve(field, positive) == pytest.approx(np.mean(pairs))


def test_strong_is_more_than_half_of_the_99th_percentile():
    change = np.linspace(-1, 1, 2001)
    assert np.abs(change[strongest(change)]).min() == pytest.approx(0.5, abs=0.01)
    assert strongest(change).sum() == pytest.approx(1010, abs=5)


@given(st.lists(st.tuples(st.integers(-3, 3), st.integers(-3, 3), st.integers(1, 4)), min_size=3, max_size=12))
def test_a_vertex_counts_as_its_area(vertices):
    """As if it were there so many times."""
    a, b, mass = (np.array(column, dtype=float) for column in zip(*vertices, strict=True))
    times = mass.astype(int)
    one, many = np.ones(times.sum()), (np.repeat(a, times), np.repeat(b, times))
    for score in (correlation, rank_correlation):
        assert score(a, b, 0.1 * mass) == pytest.approx(score(*many, one), abs=1e-9)
    positive = b > 0
    if positive.any() and not positive.all():
        found = area_under_curve(a, positive, 0.1 * mass)
        assert found == pytest.approx(area_under_curve(many[0], many[1] > 0))


def test_correlations_of_equal_areas_are_those_of_everyone():
    a, b = np.random.default_rng(0).normal(size=(2, 40)).round(1)
    ones = np.full(40, 0.3)
    assert correlation(a, b, ones) == pytest.approx(np.corrcoef(a, b)[0, 1])
    assert rank_correlation(a, b, ones) == pytest.approx(spearmanr(a, b)[0])
    assert correlation(a, np.full(40, 0.1), ones) == rank_correlation(np.zeros(40), b, ones) == 0


def test_many_small_vertices_do_not_make_a_change_strong():
    """A hundred vertices on a hundredth of the area change three times as much as the rest."""
    change, mass = np.repeat([3.0, 1.0], 100), np.repeat([0.0001, 0.0100], 100)
    assert strongest(change).sum() == 100
    assert strongest(change, mass).all()
    assert (strongest(change, np.ones(200)) == strongest(change)).all()
