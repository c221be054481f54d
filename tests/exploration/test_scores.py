import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lssd_learn.errors import InputError
from lssd_learn.exploration.scores import area_under_curve, strongest


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
