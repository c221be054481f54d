"""The checks all rooms use."""

import math

import numpy as np
import pytest

from lssd_learn.errors import InputError, check_positive, check_whole, reading


@pytest.mark.parametrize("value", [1, 5, np.int64(3)])
def test_whole_numbers_in_range_pass(value):
    check_whole("n", value, 1, 5)


@pytest.mark.parametrize("value", [0, 6, 2.0, "3", None, True, math.nan])
def test_others_are_refused_with_what_was_expected(value):
    with pytest.raises(InputError, match=rf"^n={value}: expected a whole number, 1 to 5$"):
        check_whole("n", value, 1, 5)
    if value != 6:
        with pytest.raises(InputError, match="expected a whole number, 3,000 or more$"):
            check_whole("n", value, 3000)


@pytest.mark.parametrize("value", [0, -1, math.nan, math.inf, "fast", None, True])
def test_a_number_above_zero(value):
    check_positive("rate", 0.1)
    with pytest.raises(InputError, match=f"^rate={value}: expected a number above 0$"):
        check_positive("rate", value)


def test_what_the_system_does_not_let_us_read_is_named(tmp_path):
    with pytest.raises(InputError, match=r"folder: cannot be read: Is a directory$"), reading("folder"):
        tmp_path.read_bytes()
