import numpy as np
import pytest

from lssd_learn.errors import InputError
from lssd_learn.view.fields import Field


def test_signed_values_are_blue_grey_and_red_around_zero():
    field = Field.signed("f", "f", [np.array([-1.0, 0.0, 1.0]), np.array([2.0, -2.0])])
    assert field.limits == (-field.limits[1], pytest.approx(2, rel=1e-3))
    blue, red = field.colours(1)[1].astype(int), field.colours(1)[0].astype(int)
    assert blue[2] > blue[0] + 50
    assert red[0] > red[2] + 50
    assert np.ptp(field.colours(0)[1].astype(int)) < 5


def test_squares_of_several_functions_are_added():
    field = Field.squared("f", "f", [np.array([[0.0, 0.0], [3.0, 4.0]])])
    np.testing.assert_array_equal(field.values[0], [0, 25])
    np.testing.assert_allclose(field.places(0), [0, 1], atol=1e-9)


def test_a_spike_does_not_leave_the_rest_pale():
    values = np.append(np.ones(2000), 1e6)
    field = Field.squared("f", "f", [values[:, None]])
    assert field.limits == (0, 1)
    assert field.places(0).max() == 1


def test_nothing_at_all_is_shown_as_nothing():
    np.testing.assert_array_equal(Field.squared("f", "f", [np.zeros((5, 1))]).places(0), 0)
    with pytest.raises(InputError, match="values: expected a function on one shape at least"):
        Field.signed("f", "f", [])


def test_slivers_do_not_set_the_colours():
    """A hundredth of the vertices with a millionth of the area."""
    values, areas = np.linspace(0, 1, 300), np.ones(300)
    values[:3], areas[:3] = 50, 1e-6
    assert Field.signed("f", "f", [values]).limits[1] == pytest.approx(50)
    assert Field.signed("f", "f", [values], [areas]).limits == pytest.approx((-1, 1), abs=0.01)
    assert Field.positive("f", "f", [values] * 2, [areas, 3 * areas]).limits == pytest.approx((0, 1), abs=0.01)
