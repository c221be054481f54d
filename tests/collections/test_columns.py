"""Columns that formulas speak of, and how large shapes are."""

import numpy as np
import pytest
import trimesh

from lssd_learn.collections import Folder, ShapeList
from lssd_learn.collections.columns import centroid_size, columns, enclosed_volume
from lssd_learn.errors import InputError
from lssd_learn.shapes import Mesh, PointCloud, save


def box(*sides):
    made = trimesh.creation.box(sides)
    return Mesh(np.array(made.vertices) + 5, made.faces)


def test_sizes_of_a_box_are_known():
    """Of a cube of side 2 about 0: ∫‖x‖² over a face is 4 (1 + 2/3), and there are six."""
    assert centroid_size(box(2, 2, 2)) == pytest.approx((1 + 2 / 3) ** 0.5)
    assert enclosed_volume(box(1, 2, 3)) == pytest.approx(6)
    finer = trimesh.creation.box((1, 2, 3)).subdivide().subdivide()
    finer = Mesh(finer.vertices, finer.faces)
    assert centroid_size(finer) == pytest.approx(centroid_size(box(1, 2, 3)))
    assert enclosed_volume(finer) == pytest.approx(6)


def test_columns_of_a_collection():
    shapes = ShapeList([box(1, 1, 1), box(1, 2, 3)])
    shapes.groups, shapes.parameters = {"sex": np.array(["m", ""])}, np.array([[1.0], [np.nan]])
    shapes.parameter_names = ["age"]
    found = columns(shapes, ["volume", "sex", "age", "area"])
    assert found["sex"].tolist() == ["m", None]
    assert np.isnan(found["age"][1])
    np.testing.assert_allclose([found["volume"], found["area"]], [[1, 6], [6, 22]])
    shapes.groups["size"] = np.array(["large", "small"])  # a column of the collection comes first
    assert columns(shapes, ["size"])["size"].tolist() == ["large", "small"]


def test_covariates_may_lack_some(tmp_path):
    for name in "abc":
        save(box(1, 1, 1), tmp_path / f"{name}.ply")
    (tmp_path / "labels.csv").write_text("name,age,sex,id,length\na,3,m,1,2\nb,,NA,2,3\nc,n/a,f,3,4\n")
    with pytest.raises(InputError, match="expected a value in column 'age', got an empty cell"):
        Folder(tmp_path)
    with pytest.raises(InputError, match="expected 'age' in one of them, got both"):
        Folder(tmp_path, parameters=["age"], covariates=["age"])
    folder = Folder(tmp_path, covariates=["age", "sex"])
    assert folder.parameter_names == ["length"]
    found = columns(folder, ["age", "sex", "id"])
    np.testing.assert_array_equal(found["age"], [3, np.nan, np.nan])
    assert found["sex"].tolist() == ["m", None, "f"]
    assert found["id"].tolist() == [1, 2, 3]  # no target, and yet a number
    np.testing.assert_array_equal(columns(folder[[2, 0]], ["age"])["age"], [np.nan, 3])
    assert folder.key != Folder(tmp_path, covariates=["age", "sex", "id"]).key


def test_what_cannot_be_known():
    with pytest.raises(InputError, match="no column 'sex': expected some of area, size, volume"):
        columns(ShapeList([box(1, 1, 1)]), ["sex"])
    with pytest.raises(InputError, match="area of 0: expected a mesh, got a point cloud"):
        columns(ShapeList([PointCloud(np.eye(3))]), ["area"])
    open_box = Mesh(box(1, 1, 1).vertices, box(1, 1, 1).faces[1:])
    with pytest.raises(InputError, match="volume of 0: expected a closed mesh"):
        columns(ShapeList([open_box]), ["volume"])
    turned = np.array(box(1, 1, 1).faces)
    turned[0] = turned[0, ::-1]
    with pytest.raises(InputError, match="closed mesh"):
        enclosed_volume(Mesh(box(1, 1, 1).vertices, turned))
