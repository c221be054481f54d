import numpy as np
from scipy.spatial.transform import Rotation

from lssd_learn.shapes.edges import edge_lengths, edges


def test_two_triangles_share_an_edge():
    faces = np.array([[0, 1, 2], [2, 1, 3]])
    assert edges(faces).tolist() == [[0, 1], [0, 2], [1, 2], [1, 3], [2, 3]]
    vertices = np.array([[0.0, 0, 0], [3, 0, 0], [0, 4, 0], [3, 4, 0]])
    assert edge_lengths(vertices, edges(faces)).tolist() == [3, 4, 5, 4, 3]


def test_a_closed_mesh_has_eulers_number(meshes):
    mesh = meshes[0]
    assert len(mesh.vertices) - len(edges(mesh.faces)) + len(mesh.faces) == 2


def test_rigid_motions_change_no_length_and_scale_scales_them(meshes):
    sides = edges(meshes[0].faces)
    turn = Rotation.from_rotvec([1, 2, 3]).as_matrix()
    for mesh in meshes:
        moved = mesh.vertices @ turn + 5
        np.testing.assert_allclose(edge_lengths(moved, sides), edge_lengths(mesh.vertices, sides), rtol=1e-12)
        np.testing.assert_allclose(edge_lengths(3 * mesh.vertices, sides), 3 * edge_lengths(mesh.vertices, sides))


def test_lengths_of_float32_vertices_are_float64():
    lengths = edge_lengths(np.zeros((2, 3), np.float32), np.array([[0, 1]]))
    assert (lengths.dtype, lengths.tolist()) == (np.float64, [0])
