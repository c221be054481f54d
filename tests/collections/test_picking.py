"""Slices, lists and masks of what is made when asked for."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lssd_learn.collections import Bodies, ShapeList, Subset, eigenbases
from lssd_learn.collections.picking import Picking, positions
from lssd_learn.errors import InputError


class Squares(Picking):
    """Remembers what was asked for."""

    def __init__(self, numbers):
        self.numbers, self.made = list(numbers), []

    def __len__(self):
        return len(self.numbers)

    def __getitem__(self, i):
        self.made.append(i)
        return self.numbers[i] ** 2

    def _some(self, positions):
        return Squares(self.numbers[i] for i in positions)


indices = st.one_of(
    st.slices(7), st.lists(st.integers(-7, 6)), st.lists(st.booleans(), min_size=7, max_size=7).map(np.array)
)


@given(wanted=indices)
def test_it_is_numpys_law_and_nothing_is_made_before_it_is_asked_for(wanted):
    whole = Squares(range(7))
    some = whole[wanted]
    assert (whole.made, some.made) == ([], [])
    expected = np.arange(7)[wanted if isinstance(wanted, slice | np.ndarray) else np.array(wanted, dtype=int)]
    assert list(some) == (expected**2).tolist()


def test_one_item_counts_from_the_end_too():
    whole = Squares(range(7))
    assert (whole[-1], whole[np.int64(2)], whole.made) == (36, 4, [6, 2])
    for beyond in (7, -8, [7]):
        with pytest.raises(IndexError):
            whole[beyond]


@pytest.mark.parametrize("wanted", [np.ones(6, bool), [0.5], np.zeros((2, 2), int), "ab"])
def test_what_says_nothing_of_these_items(wanted):
    with pytest.raises(InputError, match="expected"):
        positions(wanted, 7)


def test_a_part_of_a_collection_is_a_collection_with_its_key():
    bodies = Bodies(n=6, topology="notoes_collapse5pc")
    mask = bodies.parameters[:, 0] > np.median(bodies.parameters[:, 0])
    some = bodies[mask]
    assert isinstance(some, Subset)
    assert some.key == Subset(bodies, np.flatnonzero(mask)).key
    assert bodies[2:5].names == bodies.names[2:5]
    assert bodies[2:5][[2, 0]].names == [bodies.names[4], bodies.names[2]]
    np.testing.assert_array_equal(bodies[-1].vertices, bodies[5].vertices)


def test_some_bases_stay_where_they_are(meshes, cache):
    shapes = ShapeList(meshes)
    held = eigenbases(shapes, 5, cache=cache)
    shapes.key = "six"
    stored = eigenbases(shapes, 5, cache=cache)
    for bases in (held, stored):
        some = bases[np.arange(6) % 2 == 1][1:]
        assert type(some) is type(bases)
        assert [float(b.evals[3]) for b in some] == [float(bases[i].evals[3]) for i in (3, 5)]
    assert (stored[[4, 1]].keys, stored[[4, 1]].names) == ([stored.keys[4], stored.keys[1]], ["4", "1"])
