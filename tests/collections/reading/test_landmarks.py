"""Landmarks against the surfaces: missing ones, one out of line, sets in another frame or unit."""

import numpy as np
import pytest
import trimesh

from lssd_learn.collections import Folder
from lssd_learn.collections.reading.surface import Surface
from lssd_learn.errors import InputError
from lssd_learn.shapes import Mesh, PointCloud, save

MARKS = [5, 17, 40, 61, 88, 100, 131, 150]


@pytest.fixture
def landmarks(folder, lumps):
    """A function: shape → its points changed (8, 3) → the folder with all of them in landmarks.csv."""

    def write(change=None, marks=MARKS, header="name,landmark,x,y,z"):
        lines = [header]
        for i, mesh in enumerate(lumps(5)):
            points = mesh.vertices[marks]
            points = points if change is None or i not in change else change[i](points)
            lines += [f"s{i},L{k}," + ",".join(map(str, point)) for k, point in enumerate(points)]
        (folder / "landmarks.csv").write_text("\n".join(lines) + "\n")
        return Folder(folder)

    return write


def set_to(k, *values):
    def change(points):
        points = points.copy().astype(object)
        points[k] = values
        return points

    return change


def test_right_ones_are_silent(landmarks, caplog):
    shapes = landmarks()
    assert shapes.check() == []
    assert shapes.landmarks[3] == {f"L{k}": vertex for k, vertex in enumerate(MARKS)}


def test_between_vertices_they_are_on_the_surface(landmarks, lumps, caplog):
    """Half way along an edge: far from any vertex, on the surface all the same."""
    mesh = lumps(5)[2]
    middle = mesh.vertices[mesh.faces[::40]].mean(axis=1)[:8]
    np.testing.assert_allclose(Surface(mesh).distances(middle), 0, atol=1e-12)
    assert landmarks({2: lambda points: middle}).check() == []


def test_distances_are_those_to_the_nearest_point():
    square = Mesh([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]])
    points = [[0.3, 0.6, 2], [2, 0.5, 0], [2, 2, 0], [0.5, 0.5, 0]]
    np.testing.assert_allclose(Surface(square).distances(np.array(points)), [2, 1, np.sqrt(2), 0], atol=1e-12)
    cloud = PointCloud(square.vertices)
    np.testing.assert_allclose(Surface(cloud).distances(np.array(points))[3], np.sqrt(0.5))


@pytest.mark.parametrize("values", [("", "", ""), ("nan",) * 3, ("NA",) * 3, (-1, -1, -1), (-9999,) * 3, (9999,) * 3])
def test_one_that_is_missing_is_left_out(landmarks, values):
    shapes = landmarks({1: set_to(3, *values)})
    warnings = shapes.check()
    assert list(shapes.landmarks[1]) == [f"L{k}" for k in range(8) if k != 3]
    assert len(shapes.landmarks[0]) == 8
    assert len(warnings) == isinstance(values[0], int)  # a number can only be guessed to be a code
    assert all("landmark 'L3' at" in line and "is taken as missing" in line for line in warnings)


def test_a_shape_of_codes_alone_has_none(landmarks):
    shapes = landmarks({1: lambda points: np.full_like(points, -9999)})
    shapes.check()
    assert shapes.landmarks[1] == {}


def test_a_code_that_is_a_place_stays(tmp_path, folder):
    mesh = Mesh(
        np.array([[-1.0, -1, -1], [1, 0, 0], [0, 1, 0], [0, 0, 1]]), [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
    )
    from lssd_learn.shapes import save

    for file in folder.glob("*.off"):
        file.unlink()
    save(mesh, folder / "a.off")
    (folder / "landmarks.csv").write_text("name,landmark,x,y,z\na,tip,-1,-1,-1\na,side,1,0,0\n")
    assert Folder(folder).landmarks[0] == {"tip": 0, "side": 1}


def test_the_one_out_of_line_is_named(landmarks):
    shapes = landmarks({2: set_to(6, 1.2, 1.2, 1.2), 4: set_to(0, 0.1, 0.2, 0.1)})
    warnings = shapes.check()
    assert len(warnings) == 2
    assert "landmark 'L6' of s2 is off the surface by" in warnings[0]
    assert "landmark 'L0' of s4 is off the surface by" in warnings[1]


@pytest.mark.parametrize(
    ("change", "name"),
    [
        (lambda p: p * [-1, -1, 1], r"x and y negated \(LPS for RAS, or the other way\)"),
        (lambda p: p * [-1, 1, 1], "x negated"),
        (lambda p: p * [1, 1, -1], "z negated"),
        (lambda p: -p, "x, y and z negated"),
        (lambda p: p[:, [0, 2, 1]], r"\(x, z, y\) for \(x, y, z\)"),
        (lambda p: p[:, [1, 0, 2]] * [1, -1, 1], r"\(-y, x, z\) for \(x, y, z\)"),
        (lambda p: p / 1000, "1000 times as large"),
        (lambda p: p * 10, "10 times as small"),
        (lambda p: p * 25.4, "25.4 times as small"),
    ],
)
def test_a_set_in_another_frame_is_refused_and_the_frame_is_named(landmarks, change, name):
    with pytest.raises(InputError, match=f"landmarks.csv: expected landmarks on s1.off: .* with {name}"):
        landmarks({1: change}).check()


def test_few_landmarks_fit_some_frame_by_chance_and_are_left_alone(folder):
    (folder / "landmarks.csv").write_text("name,landmark,x,y,z\ns1,a,0.9,0.1,0.1\ns1,b,0.1,1.3,0.2\ns1,c,0,0.3,2.1\n")
    Folder(folder).check()


def test_a_mirrored_set_that_fits_a_symmetric_shape_is_told(tmp_path):
    """The surface cannot tell; the landmarks of the other shapes can."""
    sphere = trimesh.creation.icosphere(2)
    marks, lines = [0, 9, 33, 54, 70, 101], ["name,landmark,x,y,z"]
    for i in range(4):
        mesh = Mesh(sphere.vertices * [1, 1.5, 2 + 0.1 * i], sphere.faces)
        save(mesh, tmp_path / f"s{i}.off")
        points = mesh.vertices[marks] * ([-1, 1, 1] if i == 2 else [1, 1, 1])
        lines += [f"s{i},L{k},{x},{y},{z}" for k, (x, y, z) in enumerate(points)]
    (tmp_path / "landmarks.csv").write_text("\n".join(lines))
    (warning,) = Folder(tmp_path).check()
    assert "the landmarks of s2 lie as those of the other shapes do with x negated" in warning


def test_vertices_that_count_from_one_beside_points_are_refused(folder, lumps):
    def write(offset):
        points = lumps(1)[0].vertices[MARKS]
        rows = [
            f"s0,L{k},{v + offset},{p[0]},{p[1]},{p[2]}" for k, (v, p) in enumerate(zip(MARKS, points, strict=True))
        ]
        (folder / "landmarks.csv").write_text("name,landmark,vertex,x,y,z\n" + "\n".join(rows))

    write(0)
    assert Folder(folder).check() == []
    write(1)
    with pytest.raises(InputError, match="expected vertices counted from 0: the points x, y, z of s0.off lie at"):
        Folder(folder).check()
    (folder / "landmarks.csv").write_text("name,landmark,vertex\ns0,last,162\n")
    with pytest.raises(InputError, match=r"expected a vertex of s0.off, 0 to 161, got 162 \(is it counted from 1\?\)"):
        Folder(folder).check()
