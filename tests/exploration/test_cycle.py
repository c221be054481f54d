import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lssd_learn.errors import InputError
from lssd_learn.exploration.cycle import turning


def circle(n, turns, width=1.0):
    angles = 2 * np.pi * turns * np.arange(n) / n
    return np.stack([np.cos(angles), width * np.sin(angles)], axis=1)


@given(st.integers(7, 40), st.integers(1, 3), st.booleans(), st.floats(0, 6), st.floats(0.1, 10))
def test_steps_of_a_circle(n, turns, back, turned, scale):
    points = circle(n, turns) @ [[1, 0], [0, -1 if back else 1]]
    c, s = np.cos(turned), np.sin(turned)
    found = turning(scale * points @ [[c, -s], [s, c]] + 5)
    assert found.turns == pytest.approx(turns * (n - 1) / n)
    assert found.smallest == pytest.approx(360 * turns / n)


def test_a_flat_ellipse_is_a_circle_too():
    assert turning(circle(12, 1, 0.01)).smallest == pytest.approx(30)


def test_a_step_back():
    points = circle(12, 1)
    points[[4, 5]] = points[[5, 4]]
    assert turning(points).smallest == pytest.approx(-30)
    assert turning(points).turns == pytest.approx(11 / 12)


@pytest.mark.parametrize("points", [np.zeros((2, 2)), np.zeros((4, 3)), np.arange(8.0).reshape(4, 2)])
def test_no_circle(points):
    with pytest.raises(InputError, match="points: expected"):
        turning(points)
