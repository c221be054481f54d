import numpy as np
import pytest

from lssd_learn.collections import ShapeList
from lssd_learn.collections.subset import Subset
from lssd_learn.errors import InputError


@pytest.fixture
def whole(meshes):
    shapes = ShapeList(meshes)
    shapes.key = "six"
    shapes.up = "z"
    shapes.parameters, shapes.parameter_names = np.arange(12.0).reshape(6, 2), ["a", "b"]
    shapes.groups = {"half": np.array(list("aaabbb"))}
    shapes.landmarks = [{"nose": i} for i in range(6)]
    shapes.vertex_maps = {(0, 4): np.array([1]), (4, 0): np.array([2]), (1, 2): np.array([3])}
    shapes.parts = {"top": np.ones(162, dtype=bool)}
    return shapes


def test_all_that_is_known_goes_along(whole):
    some = Subset(whole, [4, 0, 2])
    assert (some.names, some.up, len(some)) == (["4", "0", "2"], "z", 3)
    assert [shape is whole[i] for shape, i in zip(some, (4, 0, 2), strict=True)] == [True] * 3
    np.testing.assert_array_equal(some.parameters, [[8, 9], [0, 1], [4, 5]])
    assert some.parameter_names == ["a", "b"]
    assert some.groups["half"].tolist() == ["b", "a", "a"]
    assert list(some.landmarks) == [{"nose": 4}, {"nose": 0}, {"nose": 2}]
    assert dict(some.vertex_maps) == {(1, 0): np.array([1]), (0, 1): np.array([2])}
    assert some.parts["top"].all()


def test_keys(whole):
    some = Subset(whole, [4, 0])
    assert some.shape_key(0) == whole.shape_key(4)
    assert len({whole.key, some.key, Subset(whole, [0, 4]).key, Subset(whole, range(6)).key}) == 4
    whole.key = None
    assert (some.key, some.shape_key(0)) == (None, None)


def test_nothing_known_stays_nothing(meshes):
    some = Subset(ShapeList(meshes), [1, 2])
    assert some.parameters is None
    assert (len(some.landmarks), len(some.vertex_maps), dict(some.groups)) == (0, 0, {})


@pytest.mark.parametrize("positions", [[], [0, 6], [-1], [2, 2]])
def test_positions_that_do_not_fit(whole, positions):
    with pytest.raises(InputError, match="positions: expected some of 0 to 5, each once"):
        Subset(whole, positions)
