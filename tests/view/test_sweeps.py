import numpy as np
import pytest

from lssd_learn.view.sweeps import Curve, bar_chart, curve_chart

NOT_KNOWN = [0.1, np.nan]


def test_a_band_of_one_deviation_lies_around_each_curve():
    figure = curve_chart({"a": Curve([1, 2], np.array([3.0, 4.0]), NOT_KNOWN)}, "functions", "MSE")
    (axes,) = figure.axes
    (band,) = axes.collections
    low, high = band.get_paths()[0].get_extents().intervaly
    assert (low, high) == pytest.approx((2.9, 4))  # no deviation at the second point
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("functions", "MSE")
    assert not figure.legends  # of a single curve


@pytest.mark.parametrize(("x", "scale"), [([0.001, 0.1], "log"), ([5, 50], "linear"), ([0, 100], "linear")])
def test_the_axis_of_numbers_far_apart_is_logarithmic(x, scale):
    curves = {name: Curve(x, np.ones(2), np.zeros(2)) for name in "ab"}
    figure = curve_chart(curves, "rate", "MSE")
    assert figure.axes[0].get_xscale() == scale
    assert len(figure.legends) == 1


def test_bars_stand_in_the_order_given_from_the_top():
    (axes,) = bar_chart({"first": (1.0, 0.1), "second": (2.0, np.nan)}, "MSE").axes
    assert [label.get_text() for label in axes.get_yticklabels()] == ["first", "second"]
    assert axes.yaxis_inverted()
    assert [bar.get_width() for bar in axes.patches] == [1, 2]
