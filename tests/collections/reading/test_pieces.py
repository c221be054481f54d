"""Shapes in several pieces: which are kept, and when that is refused."""

import numpy as np
import pytest

from lssd_learn.collections import Folder
from lssd_learn.errors import InputError
from lssd_learn.shapes import Mesh, eigenbasis, save


def joined(*meshes):
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
    faces = [mesh.faces + start for mesh, start in zip(meshes, starts, strict=False)]
    return Mesh(np.concatenate([mesh.vertices for mesh in meshes]), np.concatenate(faces))


def moved(mesh, x, size=1.0):
    return Mesh(size * mesh.vertices + [x, 0, 0], mesh.faces)


@pytest.fixture
def pair(tmp_path, lumps):
    """A function: sizes of the left and the right piece, a pair a shape → the folder."""

    def write(*sizes):
        for i, (mesh, (left, right)) in enumerate(zip(lumps(len(sizes)), sizes, strict=True)):
            save(joined(moved(mesh, 5, right), moved(mesh, -5, left)), tmp_path / f"s{i}.off")
        return tmp_path

    return write


def test_two_that_are_nearly_equal_are_refused(pair):
    path = pair((1, 0.95))
    with pytest.raises(
        InputError, match=r"s0.off: expected one piece that is larger .* which is meant\? \(collection.p"
    ):
        Folder(path)[0]


def test_a_side_is_kept_if_asked_for_whatever_its_size(pair):
    path = pair((1, 0.95), (0.95, 1))
    for side, sign in (("left", -1), ("right", 1)):
        for shape in Folder(path, pieces=side):
            assert shape.vertices[:, 0].mean() * sign > 4
            assert len(shape.vertices) == 162
    with pytest.raises(InputError, match="expected two pieces or more to choose the left of, got 1"):
        Folder(pair((1, 0.1)), pieces="left")[0]


@pytest.mark.parametrize(("small", "said"), [(0.2, False), (0.5, True), (0.8, True)])
def test_much_that_is_dropped_cannot_be_missed(pair, small, said):
    """Shares of the area: 4, 20 and 39 %."""
    warnings = Folder(pair((1, small))).check()
    assert len(warnings) == said
    assert all("% OF THE AREA IS DROPPED" in line for line in warnings)


def test_most_that_would_be_dropped_is_refused_unless_asked_for(tmp_path, lumps):
    mesh = lumps(1)[0]
    save(joined(mesh, *(moved(mesh, 5 * i, 0.7) for i in range(1, 5))), tmp_path / "s.off")
    with pytest.raises(
        InputError, match=r"s.off: expected one connected piece, got 5: 66 % .* \(collection.pieces=largest"
    ):
        Folder(tmp_path)[0]
    shapes = Folder(tmp_path, pieces="largest")
    (warning,) = shapes.check()
    assert "66 % OF THE AREA IS DROPPED" in warning
    np.testing.assert_allclose(shapes[0].vertices, mesh.vertices)


def test_all_are_kept_with_their_landmarks_and_have_a_basis(pair):
    path = pair((1, 0.95))
    (path / "landmarks.csv").write_text("name,landmark,vertex\ns0,a,3\ns0,b,300\n")
    shapes = Folder(path, pieces="all")
    assert shapes.check() == []
    assert (len(shapes[0].vertices), shapes[0].pieces) == (324, 2)
    assert shapes.landmarks[0] == {"a": 3, "b": 300}
    assert list(eigenbasis(shapes[0], 10).evals[:3] > 1e-3) == [False, False, True]
    assert Folder(path, pieces="all", normalise_area=True)[0].pieces == 2
    assert Folder(path, pieces="all", correspondence="none")[0].pieces == 2


def test_keys_know_the_pieces(pair):
    path = pair((1, 0.5))
    keys = {pieces: Folder(path, pieces=pieces).shape_key(0) for pieces in (None, "largest", "all", "left", "right")}
    assert keys[None] == keys["largest"]
    assert len(set(keys.values())) == 4
    with pytest.raises(InputError, match="pieces: expected largest, all, left, right or null, got 'both'"):
        Folder(path, pieces="both")


def test_another_piece_than_of_most_is_told(pair):
    """Files of the same faces: the left piece is kept of two of them, the right one of another."""
    path = pair((1, 0.6), (0.6, 1), (1, 0.6))
    (line,) = (line for line in Folder(path, pieces="largest").check() if "ANOTHER PIECE IS KEPT" in line)
    assert line.startswith("s1: ANOTHER PIECE IS KEPT than of s0, ")
    for pieces in ("left", "all"):
        assert not any("ANOTHER PIECE" in line for line in Folder(path, pieces=pieces).check())


def test_what_a_reader_left_out_is_told_once_and_remembered(tmp_path, lumps, caplog):
    save(lumps(1)[0], tmp_path / "s.stl")
    with (tmp_path / "s.stl").open("ab") as stream:
        stream.write(b"end")
    shapes = Folder(tmp_path)
    assert shapes.check() == ["s.stl: left out 3 bytes behind its end"]
    shapes[0]
    assert caplog.text.count("left out 3 bytes") == 1
