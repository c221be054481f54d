"""What tests of tasks share: runs without the command line."""

import pytest


@pytest.fixture(scope="module")
def program(pieces_of, common_cache):
    """A function (out, overrides) → the metrics of a run of this process, on one cache."""

    def run(out, *overrides, cache=common_cache):
        pieces = pieces_of(out, *overrides, f"cache={cache}")
        return pieces.task(pieces, out)

    return run
