import numpy as np
import pytest

from lssd_learn.errors import InputError
from lssd_learn.shapes import Mesh, clean, eigenbasis, is_fit_for_cotangent


def test_a_clean_mesh_comes_back_as_it_is(small_mesh):
    cleaned = clean(small_mesh)
    assert cleaned.mesh is small_mesh
    assert cleaned.repairs == ()
    assert np.array_equal(cleaned.vertex_index, np.arange(642))
    assert np.array_equal(cleaned.new_index, np.arange(642))
    assert is_fit_for_cotangent(small_mesh)


def test_the_piece_of_largest_area_stays(small_mesh, sphere):
    both = Mesh(
        np.vstack([sphere.vertices / 10, small_mesh.vertices]), np.vstack([sphere.faces, small_mesh.faces + 2562])
    )
    cleaned = clean(both)
    assert cleaned.repairs == ("kept the largest of 2 components, 642 of 3,204 vertices, 99.1 % of the area",)
    assert cleaned.mesh.connectivity == small_mesh.connectivity
    assert_indices_agree(both, cleaned)
    assert (cleaned.new_index[:2562] == -1).all()


def test_unused_vertices_are_dropped(small_mesh):
    spoilt = Mesh(np.insert(small_mesh.vertices, 5, 9, axis=0), small_mesh.faces + (small_mesh.faces >= 5))
    assert not is_fit_for_cotangent(spoilt)
    cleaned = clean(spoilt)
    assert cleaned.repairs == ("dropped 1 vertex of no face",)
    assert cleaned.mesh.connectivity == small_mesh.connectivity
    assert cleaned.new_index[5] == -1
    assert_indices_agree(spoilt, cleaned)


def test_seams_are_closed(small_mesh):
    soup = Mesh(small_mesh.vertices[small_mesh.faces].reshape(-1, 3), np.arange(3 * 1280).reshape(-1, 3))
    cleaned = clean(soup)
    assert cleaned.repairs == ("merged 3,198 border vertices with others at the same place",)
    assert len(cleaned.mesh.vertices) == 642
    assert is_fit_for_cotangent(cleaned.mesh)
    assert np.array_equal(cleaned.mesh.vertices[cleaned.new_index], soup.vertices)


def test_a_face_with_a_repeated_vertex_goes(small_mesh):
    a, b, _ = small_mesh.faces[0]
    cleaned = clean(Mesh(small_mesh.vertices, np.vstack([[[a, a, b]], small_mesh.faces])))
    assert cleaned.repairs == ("removed 1 face with a repeated vertex",)
    assert cleaned.mesh.connectivity == small_mesh.connectivity


def test_a_flat_face_stays_for_the_robust_laplacian(small_mesh):
    """A vertex in the middle of an edge, of which one neighbour does not know: a zero-area face closes the gap."""
    a, b, c = small_mesh.faces[0]
    middle = len(small_mesh.vertices)
    vertices = np.vstack([small_mesh.vertices, (small_mesh.vertices[a] + small_mesh.vertices[b]) / 2])
    mesh = Mesh(vertices, np.vstack([[[a, middle, c], [middle, b, c], [a, b, middle]], small_mesh.faces[1:]]))
    cleaned = clean(mesh)
    assert cleaned.mesh is mesh
    assert cleaned.repairs == ("left 1 zero-area face to the robust Laplacian",)
    assert not is_fit_for_cotangent(mesh)
    np.testing.assert_allclose(eigenbasis(mesh, 10).evals, eigenbasis(small_mesh, 10).evals, rtol=2e-3)


def test_non_manifold_edges_are_told(small_mesh):
    a, b, _ = small_mesh.faces[0]
    mesh = Mesh(np.vstack([small_mesh.vertices, [[2, 2, 2]]]), np.vstack([small_mesh.faces, [[a, b, 642]]]))
    assert clean(mesh).repairs == ("left 1 non-manifold edge to the robust Laplacian",)
    assert not is_fit_for_cotangent(mesh)
    assert eigenbasis(mesh, 5).k == 5


def test_a_mesh_without_area_is_refused():
    with pytest.raises(InputError, match="scan.ply: expected a mesh with a surface, all its 2 faces have zero area"):
        clean(Mesh(np.eye(3), [[0, 0, 1], [1, 2, 2]]), "scan.ply")


def assert_indices_agree(original, cleaned):
    assert np.array_equal(original.vertices[cleaned.vertex_index], cleaned.mesh.vertices)
    assert np.array_equal(cleaned.new_index[cleaned.vertex_index], np.arange(len(cleaned.mesh.vertices)))
