import json

import numpy as np
import pytest
import trimesh
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from lssd_learn.errors import InputError
from lssd_learn.shapes import Mesh, PointCloud, eigenbasis, load, read, save

EXACT = [".off", ".obj", ".ply", ".vtk", ".vtp"]
ROUNDED = [".glb"]  # float32


@pytest.fixture(scope="module")
def shuffled(small_mesh):
    """A mesh in no natural order, with two vertices at one place and one of no face."""
    order = np.random.default_rng(0).permutation(len(small_mesh.vertices))
    vertices = np.vstack([small_mesh.vertices[order], small_mesh.vertices[:1], [[9, 9, 9]]])
    faces = np.argsort(order)[small_mesh.faces]
    faces[0, faces[0] == np.argsort(order)[0]] = len(vertices) - 2
    return Mesh(vertices, faces)


@pytest.mark.parametrize("suffix", EXACT + ROUNDED)
def test_a_mesh_comes_back_in_its_order(tmp_path, shuffled, suffix):
    save(shuffled, tmp_path / f"a{suffix}")
    back = load(tmp_path / f"a{suffix}")
    assert isinstance(back, Mesh)
    assert back.connectivity == shuffled.connectivity
    np.testing.assert_allclose(back.vertices, shuffled.vertices, rtol=0 if suffix in EXACT else 1e-7)


@pytest.mark.parametrize("suffix", [*EXACT, *ROUNDED, ".xyz"])
def test_a_cloud_comes_back_in_its_order(tmp_path, shuffled, suffix):
    save(PointCloud(shuffled.vertices), tmp_path / f"a{suffix}")
    back = load(tmp_path / f"a{suffix}")
    assert isinstance(back, PointCloud)
    np.testing.assert_allclose(back.points, shuffled.vertices, rtol=1e-7 if suffix in ROUNDED else 0)


def test_stl_keeps_the_surface_and_joins_its_corners(tmp_path, small_mesh):
    save(small_mesh, tmp_path / "a.stl")
    back = load(tmp_path / "a.stl")
    assert back.vertices.shape == small_mesh.vertices.shape
    np.testing.assert_allclose(back.vertices[back.faces], small_mesh.vertices[small_mesh.faces], rtol=1e-6, atol=1e-7)


floats = st.floats(-1e6, 1e6).filter(lambda x: x == 0 or abs(x) > 1e-30)


@settings(max_examples=30, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(points=hnp.arrays(np.float64, st.tuples(st.integers(3, 6), st.just(3)), elements=floats), data=st.data())
@pytest.mark.parametrize("suffix", EXACT + ROUNDED)
def test_any_mesh_survives(tmp_path, suffix, points, data):
    corner = st.integers(0, len(points) - 1)
    mesh = Mesh(points, data.draw(st.lists(st.tuples(corner, corner, corner), min_size=1, max_size=5)))
    save(mesh, tmp_path / f"a{suffix}")
    back = load(tmp_path / f"a{suffix}")
    assert back.connectivity == mesh.connectivity
    np.testing.assert_allclose(back.vertices, points, rtol=0 if suffix in EXACT else 1e-6)


def test_obj_with_seams_materials_and_polygons_keeps_its_vertices(tmp_path):
    (tmp_path / "a.obj").write_text(
        "mtllib none.mtl\n# five corners\nv 9 9 9\nv 0 0 0 1 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvn 0 0 1\n"
        "usemtl one\nf 2/1/1 3/2/1 4/1/1 5/2/1\nusemtl two\nf -3//1 \\\n-2//1 1//1\n"
    )
    mesh = load(tmp_path / "a.obj")
    assert mesh.vertices.tolist() == [[9, 9, 9], [0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
    assert mesh.faces.tolist() == [[1, 2, 3], [1, 3, 4], [2, 3, 0]]


def test_off_quads_become_triangles(tmp_path):
    (tmp_path / "a.off").write_text("OFF # a comment\n\n4 1 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n")
    assert load(tmp_path / "a.off").area == 1


def test_xyz_knows_normals_and_leaves_them_out(tmp_path, caplog):
    (tmp_path / "a.xyz").write_text("# x y z normal\n1 2 3 0 0 1\n\n4 5 6 0 1 0\n")
    assert load(tmp_path / "a.xyz").points.tolist() == [[1, 2, 3], [4, 5, 6]]
    assert "a.xyz: columns behind x y z taken for normals, left out" in caplog.text


def test_a_glb_scene_is_one_mesh_placed_by_its_nodes(tmp_path):
    scene = trimesh.Scene()
    scene.add_geometry(trimesh.creation.box())
    scene.add_geometry(trimesh.creation.box(), transform=trimesh.transformations.translation_matrix([5, 0, 0]))
    scene.export(tmp_path / "a.glb")
    mesh = load(tmp_path / "a.glb")
    assert mesh.area == pytest.approx(12)
    assert np.ptp(mesh.vertices, axis=0).tolist() == [6, 1, 1]


def test_saving_leaves_no_other_file_and_replaces(tmp_path, small_mesh):
    (tmp_path / "a.ply").write_text("old")
    save(small_mesh, tmp_path / "a.ply")
    assert [path.name for path in tmp_path.iterdir()] == ["a.ply"]
    assert load(tmp_path / "a.ply").connectivity == small_mesh.connectivity


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("a.obj", "hello world", "expected a mesh or a point cloud, found no vertices"),
        (
            "a.obj",
            "v 0 0\n",
            "expected OBJ, it is damaged, cut off or something else: line 1 is no vertex or face: 'v 0 0'",
        ),
        ("a.obj", "v 0 0 0\nf 1 1 x\n", "line 2 is no vertex or face"),
        ("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n", "faces: expected indices from 0 to 2, got some from 0 to 3"),
        ("a.obj", "v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "finite coordinates, 1 of 3 are not, number 0 is nan 0 0"),
        ("a.off", "hello world", "expected OFF, it is damaged, cut off or something else"),
        (
            "a.off",
            "OFF\n3 2 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n",
            "it announces 3 vertices and 2 faces, 3 and 1 are there",
        ),
        ("a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n", "expected OFF, it is damaged"),
        ("a.ply", "hello world", "expected PLY, it is damaged"),
        ("a.stl", "hello world", "expected solid in its first line, or the binary form"),
        ("a.glb", "hello world", "expected GLB, it is damaged"),
        ("a.xyz", "1 2 3\n4 5\n", "line 2 does not start with three numbers: '4 5'"),
        ("a.xyz", "1 2 3\n1e200 0 0\n", r"finite coordinates, 1 of 2 are not, number 1 is 1e\+200 0 0"),
        ("a.xyz", "# nothing\n", "found no vertices"),
        ("a.xyz", "1 2 inf\n", "points: expected finite coordinates"),
        ("a.off", " \n", "expected a shape, the file is empty"),
        ("a.docx", "x", r"expected one of \.off .* \.xyz, got '\.docx'"),
        ("a", "x", "got 'no suffix'"),
    ],
)
def test_bad_files_are_refused_in_one_line_that_names_them(tmp_path, name, content, message):
    (tmp_path / name).write_text(content)
    with pytest.raises(InputError, match=message) as caught:
        load(tmp_path / name)
    assert str(tmp_path / name) in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("suffix", [".ply", ".stl", ".glb", ".off", ".vtk", ".vtp"])
@pytest.mark.parametrize("share", [0.02, 0.4, 0.95])
def test_truncated_files_are_refused(tmp_path, small_mesh, suffix, share):
    save(small_mesh, tmp_path / f"a{suffix}")
    data = (tmp_path / f"a{suffix}").read_bytes()
    (tmp_path / f"a{suffix}").write_bytes(data[: int(share * len(data))])
    with pytest.raises(InputError, match=rf"a\{suffix}: "):
        load(tmp_path / f"a{suffix}")


def test_a_truncated_stl_says_what_is_missing(tmp_path, small_mesh):
    save(small_mesh, tmp_path / "a.stl")
    data = (tmp_path / "a.stl").read_bytes()
    (tmp_path / "a.stl").write_bytes(data[:20000])
    with pytest.raises(InputError, match="a.stl: expected STL, .* it announces 1,280 faces, 398 are there"):
        load(tmp_path / "a.stl")


@pytest.mark.parametrize("share", [0.4, 0.95])
def test_truncated_text_ply_is_refused(tmp_path, small_mesh, share):
    text = trimesh.Trimesh(small_mesh.vertices, small_mesh.faces).export(file_type="ply", encoding="ascii")
    (tmp_path / "a.ply").write_bytes(text[: int(share * len(text))])
    with pytest.raises(InputError, match="a.ply: expected PLY, it is damaged, cut off"):
        load(tmp_path / "a.ply")


def test_missing_files_and_wrong_targets_are_refused(tmp_path, small_mesh):
    with pytest.raises(InputError, match="none.ply: no such file"):
        load(tmp_path / "none.ply")
    with pytest.raises(InputError, match="STL holds faces only"):
        save(PointCloud(small_mesh.vertices), tmp_path / "a.stl")
    with pytest.raises(InputError, match="XYZ holds points only"):
        save(small_mesh, tmp_path / "a.xyz")
    with pytest.raises(InputError, match="the folder .* does not exist"):
        save(small_mesh, tmp_path / "nowhere" / "a.ply")
    with pytest.raises(InputError, match="expected one of"):
        save(small_mesh, tmp_path / "a.fbx")


def test_a_glb_cannot_reach_for_another_file(tmp_path, small_mesh):
    """The format allows its numbers to lie in a file of any path; a scan from the internet shall not choose one."""
    whole = trimesh.Trimesh(small_mesh.vertices, small_mesh.faces, process=False).export(file_type="glb")
    length = int.from_bytes(whole[12:16], "little")
    tree, numbers = json.loads(whole[20 : 20 + length]), whole[28 + length :]
    (tmp_path / "private").write_bytes(numbers)
    tree["buffers"][0]["uri"] = "../private"
    text = json.dumps(tree).encode()
    text += b" " * (-len(text) % 4)
    sizes = [(20 + len(text)).to_bytes(4, "little"), len(text).to_bytes(4, "little")]
    (tmp_path / "scans").mkdir()
    (tmp_path / "scans" / "a.glb").write_bytes(whole[:8] + sizes[0] + sizes[1] + whole[16:20] + text)
    with pytest.raises(InputError, match=r"a\.glb"):
        load(tmp_path / "scans" / "a.glb")


@pytest.mark.parametrize("suffix", [".off", ".obj", ".ply", ".stl", ".glb", ".vtk", ".vtp"])
def test_a_shape_far_from_the_origin_keeps_its_form(tmp_path, small_mesh, suffix, caplog):
    far = Mesh(small_mesh.vertices + [3.9e6, 1.1e6, 4.9e6], small_mesh.faces)
    save(far, tmp_path / f"a{suffix}")
    back = load(tmp_path / f"a{suffix}")
    assert len(back.vertices) == 642
    assert not caplog.records
    np.testing.assert_allclose(back.vertices[back.faces], far.vertices[far.faces], rtol=0, atol=1e-7)
    np.testing.assert_allclose(eigenbasis(back, 5).evals, eigenbasis(far, 5).evals, rtol=1e-6, atol=1e-12)


def test_coordinates_that_have_lost_their_digits_are_refused_or_told(tmp_path, small_mesh, caplog):
    for shift, name in ((4e6, "lost.off"), (1e4, "few.off")):
        rounded = (small_mesh.vertices + shift).astype(np.float32).astype(np.float64)
        save(Mesh(rounded, small_mesh.faces), tmp_path / name)
    with pytest.raises(InputError, match=r"lost.off: its coordinates have steps of 0.25, being float32 and far"):
        load(tmp_path / "lost.off")
    load(tmp_path / "few.off")
    assert "few.off: its coordinates have steps of 0.00098" in caplog.text


@pytest.mark.parametrize("content", [".off", ".ply", ".stl", ".glb"])
def test_a_file_under_another_name_is_read_as_what_it_is(tmp_path, small_mesh, content, caplog):
    save(Mesh(small_mesh.vertices + 1e4, small_mesh.faces), tmp_path / f"a{content}")  # the STL as text
    (tmp_path / f"a{content}").rename(tmp_path / "a.obj")
    assert load(tmp_path / "a.obj").area == pytest.approx(small_mesh.area)
    assert f"it is {content[1:].upper()}, not OBJ, and read as such" in caplog.text


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"\x1f\x8b\x08rest", "it is a gzip archive"),
        (
            b"version https://git-lfs.github.com/spec/v1\noid sha256:1\n",
            "it is a pointer of Git LFS, not the file itself",
        ),
        (b"<!DOCTYPE html>", "it is XML or a web page"),
    ],
)
def test_what_is_no_shape_at_all_is_named(tmp_path, data, message):
    (tmp_path / "a.obj").write_bytes(data)
    with pytest.raises(InputError, match=message):
        load(tmp_path / "a.obj")


def test_read_gives_what_load_tells(tmp_path):
    (tmp_path / "a.xyz").write_text("1 2 3 0.5\n2 3 4 0.25\n")
    found = read(tmp_path / "a.xyz")
    assert len(found.shape.points) == 2
    assert found.notes == ("columns behind x y z taken for an intensity, left out",)
