"""The part of a shape that a mask leaves."""

import numpy as np
import pytest

from lssd_learn.collections import AlignedFolder, Folder
from lssd_learn.errors import InputError
from lssd_learn.shapes import Mesh, save
from lssd_learn.shapes.writing import ply


def opened(mesh, thickness=0.85):
    """A mesh with an inner wall, joined to it through one face: the wall has the numbers of the mesh, n on."""
    n = len(mesh.vertices)
    middle = mesh.vertices.mean(0)
    outer, inner = mesh.faces[1:], mesh.faces[1:, ::-1] + n
    a, b, c = mesh.faces[0]
    rim = [[x, y, y + n] for x, y in ((a, b), (b, c), (c, a))] + [
        [x, y + n, x + n] for x, y in ((a, b), (b, c), (c, a))
    ]
    vertices = np.concatenate([mesh.vertices, middle + thickness * (mesh.vertices - middle)])
    return Mesh(vertices, np.concatenate([outer, inner, rim]))


@pytest.fixture
def walled(lumps, tmp_path):
    for i, mesh in enumerate(lumps(2)):
        save(opened(mesh), tmp_path / f"s{i}.ply")
    return tmp_path


def test_the_inner_wall_is_cut_away_and_told(walled, lumps, caplog):
    caplog.set_level("INFO")
    whole, outer = Folder(walled)[0], Folder(walled, mask="outer")
    mesh = lumps(1)[0]
    assert len(whole.vertices) == 2 * len(mesh.vertices)
    np.testing.assert_array_equal(outer[0].vertices[:-3], mesh.vertices)  # and what is seen through the opening
    assert abs(outer[0].area / mesh.area - 1) < 0.01
    assert "mask outer took 42 % of the area" in caplog.text
    assert outer.shape_key(0) != Folder(walled).shape_key(0)


def test_what_is_outside_is_found_once(walled, cache, monkeypatch):
    first, again = Folder(walled, mask="outer"), AlignedFolder(walled, mask="outer")
    for folder in (first, again):
        folder.keep_in(cache)
    before = [shape.vertices for shape in first]
    monkeypatch.setattr("lssd_learn.collections.reading.mask.outer_faces", None)
    for shape, vertices in zip(again, before, strict=True):
        np.testing.assert_array_equal(shape.vertices, vertices)


def test_vertices_of_a_list(walled, lumps):
    (walled / "mask").mkdir()
    mesh = lumps(1)[0]
    up = np.flatnonzero(mesh.vertices[:, 2] > 0)
    for name in ("s0", "s1"):
        (walled / "mask" / f"{name}.txt").write_text("\n".join(map(str, up)))
    folder = Folder(walled, mask="vertices")
    np.testing.assert_array_equal(folder[0].vertices, mesh.vertices[up])
    assert folder.check() == []  # one list for both: they are in correspondence as they were
    assert folder[0].connectivity == folder[1].connectivity
    key = folder.shape_key(0)
    (walled / "mask" / "s0.txt").write_text("\n".join(map(str, up[1:])))
    again = Folder(walled, mask="vertices")
    assert again.shape_key(0) != key
    assert "OTHER VERTICES ARE LEFT" in again.check()[0]
    (walled / "mask" / "s0.txt").write_text("5000")
    with pytest.raises(InputError, match=r"s0.txt: expected vertices of s0.ply, 0 to 323, got 5000"):
        Folder(walled, mask="vertices")[0]
    (walled / "mask" / "s1.txt").unlink()
    with pytest.raises(InputError, match=r"s1.txt: expected a list of vertices for each shape"):
        Folder(walled, mask="vertices")


def test_what_is_painted_stays_and_greys_do_not(lumps, tmp_path):
    mesh = lumps(1)[0]
    colours = np.full((len(mesh.vertices), 3), 200, dtype=np.uint8)
    colours[mesh.vertices[:, 2] > 0] = (230, 30, 30)
    (tmp_path / "s0.ply").write_bytes(ply(mesh, colours))
    shape = Folder(tmp_path, mask="painted")[0]
    np.testing.assert_array_equal(shape.vertices, mesh.vertices[mesh.vertices[:, 2] > 0])
    save(mesh, tmp_path / "s1.off")
    with pytest.raises(InputError, match=r"s1.off: expected colours at its vertices \(PLY\)"):
        Folder(tmp_path, mask="painted")[1]


def test_a_mask_that_leaves_almost_nothing_is_refused(walled):
    (walled / "mask").mkdir()
    for name in ("s0", "s1"):
        (walled / "mask" / f"{name}.txt").write_text("0 1 2")
    with pytest.raises(
        InputError, match=r"s0.ply: expected a mask that leaves something of the shape, vertices leaves"
    ):
        Folder(walled, mask="vertices")[0]
    with pytest.raises(InputError, match="mask: expected outer, vertices, painted or null, got 'inner'"):
        Folder(walled, mask="inner")


def test_landmarks_go_to_what_is_left_if_it_is_near(walled, lumps, caplog):
    caplog.set_level("INFO")
    mesh = lumps(1)[0]
    n, far = len(mesh.vertices), int(np.argmax(mesh.vertices[:, 2]))
    near = int(np.argmin(np.linalg.norm(mesh.vertices - mesh.vertices.mean(0), axis=1)))
    (walled / "landmarks.csv").write_text(f"name,landmark,vertex\ns0,near,{near + n}\ns0,far,{far + n}\ns0,out,5\n")
    folder = Folder(walled, mask="outer")
    assert folder.landmarks[0] == {"near": near, "out": 5}
    assert "'near' of s0.ply is where the mask took the surface" in caplog.text
    assert "and is taken as missing" in caplog.text
