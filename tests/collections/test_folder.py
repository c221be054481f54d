import logging
import pickle
import shutil

import numpy as np
import pytest

from lssd_learn.collections import Folder
from lssd_learn.errors import InputError
from lssd_learn.shapes import Mesh, PointCloud, save

TETRAHEDRON = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
CORNERS = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])


def tetrahedron(size=1.0):
    return Mesh(size * CORNERS, TETRAHEDRON)


def with_crumb(size=1.0):
    """A crumb, vertices 0 to 3, close to corner 1 of a tetrahedron, vertices 4 to 7."""
    return Mesh(
        np.concatenate([0.01 * CORNERS + [1.02, 0, 0], size * CORNERS]), np.concatenate([TETRAHEDRON, TETRAHEDRON + 4])
    )


@pytest.fixture
def folder(tmp_path):
    """Three shapes: b.obj and c.ply of the same faces, a.off with a crumb."""
    save(tetrahedron(), tmp_path / "b.obj")
    save(tetrahedron(2), tmp_path / "c.PLY".lower())
    (tmp_path / "c.ply").rename(tmp_path / "c.PLY")
    save(with_crumb(), tmp_path / "a.off")
    (tmp_path / "readme.txt").write_text("not a shape")
    (tmp_path / "._b.obj").write_text("what some systems leave")
    return tmp_path


@pytest.fixture
def write_map(folder):
    (folder / "maps").mkdir()
    return lambda name, vertices: (folder / "maps" / f"{name}.txt").write_text("\n".join(map(str, vertices)))


def open_and_check(path):
    Folder(path).check()


def test_shapes_in_the_order_of_their_names(folder):
    shapes = Folder(folder)
    assert shapes.names == ["a", "b", "c"]
    assert len(shapes) == 3
    np.testing.assert_allclose(shapes[2].vertices, 2 * CORNERS)
    np.testing.assert_array_equal(shapes[-1].vertices, shapes[2].vertices)
    assert (shapes.parameters, list(shapes.parameter_names), shapes.groups) == (None, [], {})
    assert (len(shapes.landmarks), dict(shapes.vertex_maps)) == (0, {})
    with pytest.raises(IndexError):
        shapes[3]


def test_pieces_are_dropped_and_told_once(folder, caplog):
    with caplog.at_level(logging.INFO):
        shapes = Folder(folder)
        shapes[0], shapes[0]
    np.testing.assert_allclose(shapes[0].vertices, CORNERS)
    assert [m for m in caplog.messages if m.startswith("a.off: kept the largest of 2 components")] == caplog.messages


def test_the_same_faces_are_a_correspondence_and_the_log_says_so(folder, caplog):
    with caplog.at_level(logging.INFO):
        shapes = Folder(folder)
        shapes.check()
    assert shapes[1].connectivity == shapes[2].connectivity
    assert sum("have the same faces" in message for message in caplog.messages) == 1


def test_correspondence_can_be_forbidden(folder, caplog):
    with caplog.at_level(logging.INFO):
        shapes = Folder(folder, correspondence="none")
        shapes.check()
    assert shapes[1].connectivity is None
    assert pickle.loads(pickle.dumps(shapes))[1].connectivity is None
    assert "same faces" not in caplog.text


def test_clouds(folder):
    points = np.random.default_rng(0).normal(size=(9, 3))
    save(PointCloud(points), folder / "cloud.xyz")
    shapes = Folder(folder)
    np.testing.assert_allclose(shapes[3].points, points)
    (folder / "landmarks.csv").write_text("name,landmark,vertex\ncloud,top,8\n")
    assert Folder(folder).landmarks[3] == {"top": 8}
    with pytest.raises(InputError, match=r"cloud.xyz: expected a mesh \(normalise_area is on\), got a point cloud"):
        Folder(folder, normalise_area=True)[3]


def test_normalise_area(folder):
    shapes = Folder(folder, normalise_area=True)
    for shape in shapes:
        assert shape.area == pytest.approx(1)
    np.testing.assert_allclose(shapes[1].vertices, shapes[2].vertices)


def test_labels(folder):
    (folder / "labels.csv").write_text("name,mass,class,pose\nc,3,x,1\na,1,y,2\nb,2,x,1\n")
    shapes = Folder(folder, groups=["pose"])
    assert list(shapes.parameter_names) == ["mass"]
    np.testing.assert_array_equal(shapes.parameters, [[1], [2], [3]])
    assert {name: list(group) for name, group in shapes.groups.items()} == {"class": list("yxx"), "pose": list("211")}
    assert list(Folder(folder).parameter_names) == ["mass", "pose"]


def test_landmarks_follow_the_cleaned_vertices(folder):
    (folder / "landmarks.csv").write_text(
        "name,landmark,vertex,x,y,z\na,by vertex,6,9,9,9\na,by point,,0,0,1.1\nc,by point,,0,2.1,0\n"
    )
    shapes = Folder(folder)
    assert list(shapes.landmarks) == [{"by vertex": 2, "by point": 3}, {}, {"by point": 2}]
    np.testing.assert_allclose(shapes[0].vertices[3], [0, 0, 1])
    assert pickle.loads(pickle.dumps(shapes)).landmarks[2] == {"by point": 2}


def test_two_landmarks_on_one_vertex_are_a_warning(folder, caplog):
    (folder / "landmarks.csv").write_text("name,landmark,vertex\nb,left,1\nb,right,1\nb,top,3\n")
    shapes = Folder(folder)
    with caplog.at_level(logging.WARNING):
        assert shapes.landmarks[1] == {"left": 1, "right": 1, "top": 3}
        shapes.landmarks[1]
    assert caplog.messages == ["b: landmarks at one vertex: left and right"]


@pytest.mark.parametrize(
    ("row", "message"),
    [
        ("b,nose,4,,,", r"line 2: expected a vertex of b.obj, 0 to 3, got 4"),
        ("a,nose,2,,,", r"line 2: expected a vertex of the largest component of a.off, landmark 'nose' is at vertex 2"),
        ("a,nose,,1.02,0,0", r"line 2: expected a vertex of the largest component of a.off"),
    ],
)
def test_landmarks_that_are_not_there(folder, row, message):
    (folder / "landmarks.csv").write_text(f"name,landmark,vertex,x,y,z\n{row}\n")
    shapes = Folder(folder)
    shapes[0]
    with pytest.raises(InputError, match=message):
        shapes.check()


def test_maps_follow_the_cleaned_vertices(folder, write_map, caplog):
    write_map("b__c", [3, 2, 1, 0])
    write_map("b__a", [0, 0, 0, 0, 3, 2, 1, 0])
    write_map("a__b", [4, 5, 0, 7])
    maps = Folder(folder).vertex_maps
    assert set(maps) == {(1, 2), (1, 0), (0, 1)}
    np.testing.assert_array_equal(maps[1, 2], [3, 2, 1, 0])
    np.testing.assert_array_equal(maps[1, 0], [3, 2, 1, 0])
    with caplog.at_level(logging.INFO):
        np.testing.assert_array_equal(maps[0, 1], [0, 1, 1, 3])
    assert "a__b.txt: 1 vertex led to a dropped piece" in caplog.text


@pytest.mark.parametrize(
    ("name", "vertices", "message"),
    [
        ("b__c", [0, 1, 2], r"b__c.txt: expected a vertex of b for each of the 4 vertices of c, got 3"),
        ("b__a", [0, 1, 2, 3], r"b__a.txt: expected a vertex of b for each of the 8 vertices of a, got 4"),
        ("b__c", [0, 1, 2, 4], r"b__c.txt: expected vertices of b, 0 to 3, got 4"),
        ("b__c", [0, 1, 2, -1], r"b__c.txt: expected vertices of b, 0 to 3, got -1"),
        ("b__c", [0, 1, 2, 2.5], r"b__c.txt: expected whole numbers, one a line"),
        ("b__c", [0, 1, 2, 10**30], r"b__c.txt: expected whole numbers, one a line"),
        ("b__d", [0], r"b__d.txt: expected a name A__B.txt of two shapes of the folder"),
        ("b-c", [0], r"b-c.txt: expected a name A__B.txt of two shapes of the folder"),
    ],
)
def test_bad_maps(folder, write_map, name, vertices, message):
    write_map(name, vertices)
    with pytest.raises(InputError, match=message):
        open_and_check(folder)


def test_names_with_underscores(folder, write_map):
    shutil.copy(folder / "b.obj", folder / "b__c.obj")
    write_map("b__c__c", [0, 1, 2, 3])
    assert set(Folder(folder).vertex_maps) == {(2, 3)}
    shutil.copy(folder / "b.obj", folder / "c__b.obj")
    write_map("b__c__b", [0, 1, 2, 3])  # from b to c__b, or from b__c to b?
    with pytest.raises(InputError, match="expected a name A__B.txt"):
        Folder(folder)


def test_keys_tell_bytes_names_and_arguments(folder):
    (folder / "labels.csv").write_text("name,mass\na,1\nb,2\nc,3\n")
    before, same = Folder(folder), Folder(folder)
    shape_keys = [before.shape_key(i) for i in range(3)]
    keys = {before.key, same.key}
    assert len(keys) == 1
    assert len(set(shape_keys)) == 3

    keys |= {
        Folder(folder, **{name: value}).key
        for name, value in (("correspondence", "none"), ("groups", ["mass"]), ("normalise_area", True), ("up", "y"))
    }
    assert len(keys) == 5
    assert Folder(folder, normalise_area=True).shape_key(0) != shape_keys[0]
    assert Folder(folder, correspondence="none").shape_key(0) != shape_keys[0]
    assert Folder(folder, up="y", groups=["mass"]).shape_key(0) == shape_keys[0]

    (folder / "labels.csv").write_text("name,mass\na,1\nb,2\nc,4\n")
    keys.add(Folder(folder).key)
    assert [Folder(folder).shape_key(i) for i in range(3)] == shape_keys
    save(tetrahedron(3), folder / "b.obj")
    keys.add(Folder(folder).key)
    after = [Folder(folder).shape_key(i) for i in range(3)]
    assert [old == new for old, new in zip(shape_keys, after, strict=True)] == [True, False, True]
    (folder / "labels.csv").unlink()
    (folder / "b.obj").rename(folder / "d.obj")
    keys.add(Folder(folder).key)
    assert Folder(folder).shape_key(2) == after[1]
    assert len(keys) == 8


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"correspondence": "maybe"}, r"correspondence: expected auto or none, got 'maybe'"),
        ({"up": "x"}, r"up: expected y or z, got 'x'"),
        ({"groups": "class"}, r"groups: expected a list of columns of labels.csv, got 'class'"),
        ({"groups": ["class"]}, r"labels.csv: expected this file with a column 'class' to group by, it is not there"),
    ],
)
def test_bad_arguments(folder, arguments, message):
    with pytest.raises(InputError, match=message):
        Folder(folder, **arguments)


def test_bad_folders(folder, tmp_path):
    with pytest.raises(InputError, match=r"nowhere: expected a folder of shapes, it is not there"):
        Folder(tmp_path / "nowhere")
    with pytest.raises(InputError, match=r"b.obj: expected a folder of shapes, it is a file"):
        Folder(folder / "b.obj")
    (tmp_path / "empty").mkdir()
    with pytest.raises(InputError, match=r"empty: expected shapes \(.off .*\), found none"):
        Folder(tmp_path / "empty")
    save(tetrahedron(), folder / "b.stl")
    with pytest.raises(InputError, match=r"expected one file a name, got b.obj and b.stl"):
        Folder(folder)


def test_a_mesh_file_without_faces_is_told(folder, caplog):
    save(PointCloud(CORNERS), folder / "d.ply")
    with caplog.at_level(logging.INFO):
        Folder(folder)[3]
    assert caplog.messages == ["d.ply: no faces in it, taken as a point cloud"]


def test_a_landmark_in_another_unit_is_refused(folder):
    (folder / "landmarks.csv").write_text("name,landmark,x,y,z\nb,nose,0,0,1000\n")
    with pytest.raises(
        InputError, match="line 2: expected landmark 'nose' near b.obj, which is 1 across; it is 999 away"
    ):
        Folder(folder).check()


def test_a_broken_file_is_noticed_when_it_is_read(folder):
    (folder / "b.obj").write_text("v 1 2\n")
    shapes = Folder(folder)
    shapes[0]
    with pytest.raises(InputError, match=r"b\.obj"):
        shapes[1]
