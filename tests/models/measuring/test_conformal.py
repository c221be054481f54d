import numpy as np
import pytest

from lssd_learn.models.measuring.conformal import conformal_width


def test_the_width_is_the_error_of_the_rank_that_finite_samples_ask_for():
    errors = np.array([[-9.0], [1], [2], [-3], [4], [5], [6], [7], [8]])
    assert conformal_width(errors, 0.9).tolist() == [9.0]
    assert conformal_width(errors, 0.5).tolist() == [5.0]
    assert np.isinf(conformal_width(errors[1:], 0.9)).all()


@pytest.mark.parametrize("n", [19, 40, 99])
def test_intervals_hold_as_often_as_they_say_whatever_the_errors_are(n):
    """Over many calibration sets the coverage lies between the level and 1 / (n + 1) above it."""
    draws = np.random.default_rng(0).standard_t(2, (4000, n + 1, 1)) + 0.7
    held = np.mean([abs(one[-1, 0]) <= conformal_width(one[:-1], 0.9)[0] for one in draws])
    assert 0.9 - 0.015 < held < 0.9 + 1 / (n + 1) + 0.015
