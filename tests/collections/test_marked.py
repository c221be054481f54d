"""Where landmarks lie beside their shapes: as the file says it, and moved as the shapes are."""

import numpy as np
import pytest

from lssd_learn.collections import Bumps, Folder, ShapeList
from lssd_learn.collections.aligned import Aligned
from lssd_learn.collections.landmark_files.table import write_table
from lssd_learn.shapes import save

MARKS = [3, 70]


@pytest.fixture
def folder(tmp_path):
    """Three spheres with bumps and their landmarks, above the surface, on it and missing."""
    shapes = Bumps(heights=[(0.5, 0.1), (0.4, 0.2), (0.1, 0.5)], subdivisions=2)
    points = np.array([shape.vertices[MARKS] * [[1.1], [1.0]] for shape in shapes])
    points[2, 0] = np.nan
    for i, shape in enumerate(shapes):
        save(shape, tmp_path / f"s{i}.ply")
    write_table(tmp_path / "landmarks.csv", ["s0", "s1", "s2"], ["a", "b"], points, np.ones((3, 2)), points[..., 0] > 0)
    return tmp_path, points


def test_points_are_those_of_the_file_with_every_digit(folder):
    path, points = folder
    shapes = Folder(path)
    assert [list(shapes.marked(i)) for i in range(3)] == [["a", "b"], ["a", "b"], ["b"]]
    np.testing.assert_array_equal(shapes.marked(0)["a"], points[0, 0])
    np.testing.assert_array_equal(shapes[1:].marked(1)["b"], points[2, 1])
    unit = Folder(path, normalise_area=True)
    np.testing.assert_allclose(unit.marked(0)["a"], points[0, 0] / np.sqrt(shapes[0].area))
    assert Folder(path).marked(0).keys() == unit.marked(0).keys()


def test_they_are_laid_as_the_shapes_are(folder):
    laid = Aligned(Folder(folder[0], correspondence="none"), cache=None)
    for i in range(3):
        np.testing.assert_allclose(laid.marked(i)["b"], laid[i].vertices[MARKS[1]], atol=1e-6)


def test_those_of_generated_shapes_are_vertices_and_others_have_none():
    shapes = ShapeList(Bumps(subdivisions=1))
    assert shapes.marked(0) == {}
    shapes.landmarks = [{"a": 4}] * 4
    np.testing.assert_array_equal(shapes.marked(2)["a"], shapes[2].vertices[4])
