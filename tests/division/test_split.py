import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lssd_learn.errors import InputError
from lssd_learn.learning import split


def test_sizes_of_the_paper():
    parts = split(400, 0)
    assert [len(parts.train), len(parts.test), len(parts.validation)] == [300, 60, 40]


@settings(max_examples=50, deadline=None)
@given(n=st.integers(10, 500), seed=st.integers(0, 2**32))
def test_parts_are_disjoint_and_make_up_the_whole(n, seed):
    parts = split(n, seed)
    together = np.concatenate([positions for _, positions in parts.items()])
    np.testing.assert_array_equal(np.sort(together), np.arange(n))


def test_seed_decides():
    assert all((a == b).all() for (_, a), (_, b) in zip(split(400, 0).items(), split(400, 0).items(), strict=True))
    assert (split(400, 0).test != split(400, 1).test).any()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"n": 4, "seed": 0}, "4 shapes are too few"),
        ({"n": 4, "seed": 0, "held_out": [0, 1, 2]}, "4 shapes are too few"),
        ({"n": 40, "seed": 0, "fractions": {"train": 0.9, "test": 0.2, "validation": 0.1}}, "in sum 1"),
        ({"n": 40, "seed": 0, "fractions": {"train": 0.9, "test": 0.1}}, "wants train, test and validation"),
        ({"n": 40, "seed": -1}, "seed"),
    ],
)
def test_errors(arguments, message):
    with pytest.raises(InputError, match=message):
        split(**arguments)


@settings(max_examples=60, deadline=None)
@given(sizes=st.lists(st.integers(1, 9), min_size=3, max_size=40), seed=st.integers(0, 2**32))
def test_no_block_stands_on_two_sides(sizes, seed):
    blocks = np.random.default_rng(seed).permutation(np.repeat(np.arange(len(sizes)), sizes))
    parts = dict(split(len(blocks), seed, blocks=blocks).items())
    together = np.concatenate(list(parts.values()))
    np.testing.assert_array_equal(np.sort(together), np.arange(len(blocks)))
    on = [set(blocks[positions]) for positions in parts.values()]
    assert sum(map(len, on)) == len(sizes)
    assert all(on)


def test_blocks_come_near_to_the_fractions_and_the_seed_decides():
    blocks = np.repeat(np.arange(100), 4)
    parts = split(400, 0, blocks=blocks)
    assert [len(parts.train), len(parts.test), len(parts.validation)] == [300, 60, 40]
    assert (parts.test != split(400, 1, blocks=blocks).test).any()


def test_a_block_is_held_out():
    blocks = np.repeat(np.arange(10), 4)
    parts = split(40, 0, held_out=np.flatnonzero(blocks == 3), blocks=blocks)
    assert set(blocks[parts.test]) == {3}
    assert len(set(blocks[parts.validation])) == 1
    with pytest.raises(InputError, match="2 blocks are too few to split into"):
        split(8, 0, blocks=np.repeat([0, 1], 4))
