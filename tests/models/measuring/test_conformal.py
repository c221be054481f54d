import numpy as np
import pytest

from lssd_learn.models.measuring.conformal import Widths, conformal_width


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


@pytest.mark.parametrize("kind", [0, 1])
def test_intervals_by_class_hold_for_those_that_look_well_and_for_those_that_do_not(kind):
    """Errors ten times as large where what is seen says so: each kind is held as often as it is said."""
    rng = np.random.default_rng(0)

    def drawn(n):
        seen = rng.integers(0, 2, size=(n, 1)).astype(float)
        return seen, rng.normal(size=(n, 2)) * 0.01 * 10**seen

    held = []
    for _ in range(60):
        widths = Widths.of(*drawn(200), classes=2, level=0.9)
        seen, errors = drawn(100)
        some = seen[:, 0] == kind
        held.append(np.mean([np.abs(e) <= widths(s) for s, e in zip(seen[some], errors[some], strict=True)]))
    assert 0.88 < np.mean(held) < 0.94


def test_what_is_beyond_all_that_was_seen_counts_as_the_farthest():
    rng = np.random.default_rng(0)
    seen = rng.random((100, 1))
    widths = Widths.of(seen, rng.normal(size=(100, 1)) * np.exp(3 * seen), 2, 0.9)
    np.testing.assert_array_equal(widths(np.array([50.0])), widths(seen.max(0)))
    assert widths(np.array([50.0])) > widths(np.array([0.0]))
