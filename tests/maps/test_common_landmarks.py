"""Landmarks where they enter: what all shapes have, spread out, and one line for what is wrong."""

import numpy as np
import pytest

from lssd_learn.collections import ShapeList
from lssd_learn.errors import InputError
from lssd_learn.maps.common_landmarks import SharedLandmarks, common_landmarks
from lssd_learn.shapes.sampling import farthest_points

MARKS = {"nose": 5, "ear": 40, "tail": 100, "paw": 7, "knee": 61}


@pytest.fixture
def collection(meshes):
    """A function: landmarks of three shapes → the collection of these."""

    def make(*marks):
        shapes = ShapeList(meshes[: len(marks)])
        shapes.names, shapes.landmarks = ["cat", "lion", "cub"][: len(marks)], marks
        return shapes

    return make


def test_those_that_all_shapes_have_in_the_order_of_the_first(collection, caplog):
    caplog.set_level("INFO")
    other = {"tail": 1, "knee": 2, "nose": 3, "wing": 9}
    vertices = common_landmarks(collection(MARKS, other, MARKS))
    np.testing.assert_array_equal(vertices, [[5, 100, 61], [3, 1, 2], [5, 100, 61]])
    assert "3 of 6 landmarks are on all shapes" in caplog.text


def test_two_shapes_are_mapped_by_what_they_share(collection):
    a, b, c = dict(MARKS), dict(MARKS), dict(MARKS)
    del a["nose"], b["ear"], c["tail"]
    shared = SharedLandmarks(collection(a, b, c))
    for i, j, marks in (
        (0, 1, ["tail", "paw", "knee"]),
        (1, 2, ["paw", "knee", "nose"]),
        (2, 0, ["ear", "paw", "knee"]),
    ):
        first, second = shared.of_pair(i, j)
        assert sorted(first) == sorted(second) == sorted(MARKS[mark] for mark in marks)
        np.testing.assert_array_equal(first, second)
    with pytest.raises(InputError, match="expected 3 landmarks or more that all shapes have, got 2"):
        shared.of_all()
    lone = {"nose": 5, "wing": 40, "horn": 100}
    with pytest.raises(InputError, match="^maps: expected 3 landmarks or more that cat and lion share, got 1$"):
        SharedLandmarks(collection(MARKS, lone)).of_pair(0, 1)


def test_a_missing_one_does_not_cost_the_others(collection, meshes):
    """With a count too: the farthest are chosen on the shape that has most."""
    poor = {mark: vertex for mark, vertex in MARKS.items() if mark != "tail"}
    shared = SharedLandmarks(collection(poor, MARKS), 4)
    of_all = np.array(list(MARKS.values()))
    far = set(of_all[farthest_points(meshes[1].vertices[of_all], 4)].tolist())
    assert {MARKS[mark] for mark in shared.order} == far
    assert set(shared.of_pair(0, 1)[0]) == far - {MARKS["tail"]}


def test_some_are_the_farthest_on_the_first_shape(collection, meshes):
    reversed_ = dict(reversed(MARKS.items()))
    shapes = collection(MARKS, reversed_)
    vertices = common_landmarks(shapes, 3)
    of_all = np.array(list(MARKS.values()))
    far = of_all[farthest_points(meshes[0].vertices[of_all], 3)]
    assert set(vertices[0]) == set(far)
    np.testing.assert_array_equal(vertices[0], vertices[1])


def test_what_is_wrong_is_told_in_one_line(collection, meshes):
    with pytest.raises(InputError, match="^maps: expected landmarks on every shape, lion has none"):
        common_landmarks(collection(MARKS, {}))
    with pytest.raises(InputError, match="^maps: expected 3 landmarks or more on every shape, lion has 2$"):
        common_landmarks(collection(MARKS, {"nose": 1, "ear": 2}))
    with pytest.raises(InputError, match="^maps: expected landmarks of lion at vertices 0 to 161, got 162$"):
        common_landmarks(collection(MARKS, MARKS | {"ear": 162}))
    with pytest.raises(InputError, match=r"^maps.landmarks=6: expected a whole number, 3 to 5$"):
        common_landmarks(collection(MARKS, MARKS), 6)
    on_a_line = {"nose": 5, "ear": 5, "tail": 100}
    with pytest.raises(InputError, match="^maps: expected landmarks around the shape, the 3 of cat are on a line$"):
        common_landmarks(collection(on_a_line, MARKS))
