"""Work on many shapes: the results come in order, and what is sent for a shape does not grow with their number."""

import operator

import pytest

from lssd_learn.collections.parallel import ROUND, SHARES, in_parallel


class Sent:
    """Three, which knows how often it was sent."""

    times = 0

    def __reduce__(self):
        Sent.times += 1
        return int, (3,)


@pytest.mark.parametrize("number", [2, 7, 640])
def test_results_come_in_order_and_what_all_need_is_sent_a_few_times(number):
    Sent.times = 0
    found = list(in_parallel(operator.mul, range(number), "products", 2, Sent()))
    assert found == [3 * i for i in range(number)]
    assert Sent.times <= max(2 * SHARES + 2, number / ROUND)


def test_an_error_comes_as_it_is():
    with pytest.raises(ZeroDivisionError):
        list(in_parallel(operator.floordiv, range(40), "quotients", 2, 0))
