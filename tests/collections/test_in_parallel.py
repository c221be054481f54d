"""Work on many shapes: the results come in order, and what is sent for a shape does not grow with their number."""

import operator
import os
import subprocess
import sys
import textwrap
from pathlib import Path

import pytest

import lssd_learn
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


GROWS = """
    import time
    import numpy as np
    kept = []

    def grow(i):
        if i > 1:
            time.sleep(0.6)
            kept.append(np.ones(40_000_000))  # .3 GB
        return i
"""


def test_workers_that_grow_are_replaced_where_warnings_are_errors(tmp_path):
    pytest.importorskip("psutil")  # without it joblib does not look
    (tmp_path / "grows.py").write_text(textwrap.dedent(GROWS))
    code = (
        "from grows import grow\nfrom lssd_learn.collections.parallel import in_parallel\n"
        "print(list(in_parallel(grow, range(6), 'pieces', 2)))"
    )
    path = os.pathsep.join([str(tmp_path), str(Path(lssd_learn.__file__).parents[1])])
    line = [sys.executable, "-W", "error", "-c", code]
    done = subprocess.run(line, env={**os.environ, "PYTHONPATH": path}, capture_output=True, text=True, timeout=120)
    assert done.stdout == f"{list(range(6))}\n", done.stderr
