import numpy as np
import pytest

from lssd_learn.errors import InputError
from lssd_learn.shapes import Mesh, PointCloud

CORNERS = np.array([[0.0, 0, 0], [3, 0, 0], [0, 4, 0]])


def test_a_right_triangle_has_its_area():
    mesh = Mesh(CORNERS, [[0, 1, 2]])
    assert mesh.area == 6
    assert mesh.face_areas.tolist() == [6]


def test_arrays_are_converted_copied_and_read_only():
    vertices = CORNERS.astype(np.float32)
    mesh = Mesh(vertices, np.array([[0, 1, 2]], dtype=np.uint8))
    vertices[:] = 7
    assert mesh.vertices.dtype == np.float64
    assert mesh.faces.dtype == np.int64
    assert np.array_equal(mesh.vertices, CORNERS)
    with pytest.raises(ValueError, match="read-only"):
        mesh.vertices[0, 0] = 1
    assert Mesh(2 * CORNERS, mesh.faces).faces is mesh.faces


def test_connectivity_depends_on_faces_and_vertex_count_only():
    mesh = Mesh(CORNERS, [[0, 1, 2]])
    assert mesh.connectivity == Mesh(2 * CORNERS, np.array([[0, 1, 2]], dtype=np.int32)).connectivity
    assert mesh.connectivity != Mesh(CORNERS, [[0, 2, 1]]).connectivity
    assert mesh.connectivity != Mesh(np.vstack([CORNERS, [1, 1, 1]]), [[0, 1, 2]]).connectivity
    assert PointCloud(CORNERS).connectivity is None


def test_mesh_and_cloud_answer_to_both_names():
    mesh, cloud = Mesh(CORNERS, [[0, 1, 2]]), PointCloud(CORNERS)
    assert mesh.points is mesh.vertices
    assert cloud.vertices is cloud.points


@pytest.mark.parametrize(
    ("vertices", "faces", "message"),
    [
        (CORNERS[:, :2], [[0, 1, 2]], r"vertices: expected an array of shape \(V, 3\) with V ≥ 1, got \(3, 2\)"),
        (np.empty((0, 3)), [[0, 1, 2]], r"vertices: .* got \(0, 3\)"),
        (CORNERS * [1, 1, np.nan], [[0, 1, 2]], "vertices: expected finite coordinates, 3 of 3 are not"),
        ([["a", "b", "c"]], [[0, 1, 2]], "vertices: expected numbers"),
        ([[0, 1, 2], [3]], [[0, 1, 2]], "vertices: .*rows of different lengths"),
        (CORNERS, np.empty((0, 3), int), r"faces: expected an array of shape \(F, 3\) with F ≥ 1, got \(0, 3\)"),
        (CORNERS, [[0, 1, 2, 2]], r"faces: .* got \(1, 4\)"),
        (CORNERS, [[0, 1, 3]], "faces: expected indices from 0 to 2, got some from 0 to 3"),
        (CORNERS, [[0, 1, -1]], "faces: expected indices from 0 to 2, got some from -1 to 1"),
        (CORNERS, [[0, 1, 1.5]], "faces: expected vertex indices, got numbers that are not whole"),
    ],
)
def test_bad_arrays_are_refused(vertices, faces, message):
    with pytest.raises(InputError, match=message):
        Mesh(vertices, faces)


def test_bad_points_are_refused():
    with pytest.raises(InputError, match=r"points: expected an array of shape \(V, 3\)"):
        PointCloud([1, 2, 3])
