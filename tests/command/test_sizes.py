"""Sizes that nobody typed come down with those that are; typed ones are never changed."""

import pytest

from lssd_learn.command.sizes import bring_down
from lssd_learn.errors import InputError


def sizes(k, size=64, keep=40):
    return {"basis": {"k": k}, "latent": {"size": size, "keep": keep}}


@pytest.mark.parametrize(
    ("k", "typed", "expected"),
    [(50, ["basis.k=50"], (50, 40)), (30, ["basis.k=30"], (30, 30)), (30, ["latent.keep=20"], (30, 20)),
     (80, [], (64, 40))],
)  # fmt: skip
def test_what_is_too_large_comes_down_and_is_told(k, typed, expected):
    config = sizes(k, keep=20 if "latent.keep=20" in typed else 40)
    line = bring_down(config, typed)
    assert (config["latent"]["size"], config["latent"]["keep"]) == expected
    if k == 80:
        assert line is None
    else:
        assert line.startswith(f"basis.k={k}, latent.size={expected[0]}, latent.keep={expected[1]}: ")


@pytest.mark.parametrize("typed", [["basis.k=30", "latent.size=64"], ["basis.k=30", "latent.keep=40"]])
def test_what_was_typed_stays_and_is_refused_with_all_three(typed):
    with pytest.raises(InputError, match=r"expected 1 to .*=30, but here basis.k=30 latent.size=64 latent.keep=40$"):
        bring_down(sizes(30), typed)
