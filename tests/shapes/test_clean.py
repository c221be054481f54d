import numpy as np
import pytest
import trimesh

from lssd_learn.errors import InputError
from lssd_learn.shapes import Mesh, clean, eigenbasis, is_fit_for_cotangent, keep, mend


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


def halves(mesh, gap=0.0):
    """The vertices between two halves twice, the second time a little further."""
    beyond = mesh.vertices[mesh.faces].mean(axis=1)[:, 0] > 0
    shared = np.intersect1d(mesh.faces[beyond], mesh.faces[~beyond])
    number = np.arange(len(mesh.vertices))
    number[shared] = len(mesh.vertices) + np.arange(len(shared))
    vertices = np.vstack([mesh.vertices, mesh.vertices[shared] + gap])
    return Mesh(vertices, np.where(beyond[:, None], number[mesh.faces], mesh.faces)), len(shared)


@pytest.mark.parametrize("gap", [0, 1e-9, 1e-7])
@pytest.mark.parametrize("shift", [0, 4e6])
def test_halves_a_hair_apart_are_one(small_mesh, gap, shift):
    spoilt, n = halves(small_mesh, gap)
    spoilt = Mesh(spoilt.vertices + shift, spoilt.faces)
    cleaned = clean(spoilt)
    assert len(cleaned.repairs) == 1
    assert cleaned.repairs[0].startswith(f"merged {n} border vertices with others at the same place")
    assert ("apart" in cleaned.repairs[0]) == (gap > 0 and gap + shift != shift)
    assert cleaned.mesh.connectivity == small_mesh.connectivity
    assert cleaned.piece_areas == pytest.approx([cleaned.mesh.area])
    assert_indices_agree(spoilt, cleaned)
    np.testing.assert_allclose(cleaned.mesh.vertices[cleaned.new_index], spoilt.vertices, atol=2 * gap + 1e-15)


def test_a_seam_of_a_texture_closes(small_mesh):
    """From pole to pole only: one piece all the time, and first eigenvalue of a slit surface if left."""
    spoilt, _ = halves(small_mesh)
    front = spoilt.vertices[:, 1] < 0
    slit = Mesh(spoilt.vertices, np.where(front[spoilt.faces], clean(spoilt).new_index[spoilt.faces], spoilt.faces))
    assert len(clean(slit).piece_areas) == 1
    assert (
        eigenbasis(
            Mesh(slit.vertices[np.unique(slit.faces)], np.unique(slit.faces, return_inverse=True)[1].reshape(-1, 3)), 2
        ).evals[1]
        < 0.9 * eigenbasis(small_mesh, 2).evals[1]
    )
    np.testing.assert_allclose(eigenbasis(clean(slit).mesh, 8).evals, eigenbasis(small_mesh, 8).evals, rtol=1e-9)


def test_a_real_gap_stays(small_mesh):
    spoilt, _ = halves(small_mesh, 1e-3)
    cleaned = clean(spoilt, "scan")
    assert len(cleaned.piece_areas) == 2
    assert 0.3 < cleaned.dropped < 0.5
    assert "kept the largest of 2 components" in cleaned.repairs[0]


def test_vertices_inside_that_touch_stay_apart(square):
    """A sheet pinched to itself in an inner vertex, and two sheets with one corner in common."""
    flat = square(6)
    above = flat.vertices + [0, 0, 1.0]
    above[24] = flat.vertices[24]  # the middle
    both = Mesh(np.vstack([flat.vertices, above]), np.vstack([flat.faces, flat.faces + 49]))
    assert len(mend(both).piece_areas) == 2
    corner = Mesh(np.vstack([flat.vertices, flat.vertices + [1, 1, 0]]), np.vstack([flat.faces, flat.faces + 49]))
    assert mend(corner).repairs == ()
    assert len(mend(corner).piece_areas) == 2


def test_faces_given_twice_go(small_mesh):
    twice = np.vstack([small_mesh.faces, small_mesh.faces[:50], small_mesh.faces[50:60, ::-1]])
    cleaned = clean(Mesh(small_mesh.vertices, twice))
    assert cleaned.repairs == ("removed 60 faces given twice",)
    assert cleaned.mesh.connectivity == small_mesh.connectivity


@pytest.mark.parametrize("own", [False, True])
def test_a_sheet_with_two_sides_has_one(square, own):
    flat = square(5)
    other = flat.faces[:, ::-1] + own * len(flat.vertices)
    spoilt = Mesh(np.vstack([flat.vertices] * (1 + own)), np.vstack([flat.faces, other]))
    cleaned = clean(spoilt)
    assert cleaned.mesh.connectivity == flat.connectivity
    assert cleaned.mesh.area == pytest.approx(1)
    assert "50 faces" in cleaned.repairs[0]
    assert cleaned.dropped == 0


def test_cells_that_share_a_wall_keep_it():
    box = trimesh.creation.box()
    vertices = np.vstack([box.vertices, box.vertices + [1, 0, 0]])
    whole = mend(Mesh(vertices, np.vstack([box.faces, box.faces + 8])))
    np.testing.assert_allclose(whole.piece_areas, [6, 6])
    assert whole.repairs == ()


@pytest.mark.parametrize("share", [0.1, 0.4])
def test_mixed_winding_is_mended(small_mesh, share):
    some = np.random.default_rng(0).random(1280) < share
    cleaned = clean(
        Mesh(small_mesh.vertices, np.where(some[:, None], small_mesh.faces[:, [0, 2, 1]], small_mesh.faces))
    )
    assert cleaned.repairs == (f"turned {some.sum()} faces to face as the others do",)
    assert cleaned.mesh.connectivity == small_mesh.connectivity


def test_a_moebius_strip_stays_as_it_is():
    n = 20
    t = 2 * np.pi * np.arange(n) / n
    rim = [
        np.stack([(1 + w * np.cos(t / 2)) * np.cos(t), (1 + w * np.cos(t / 2)) * np.sin(t), w * np.sin(t / 2)], 1)
        for w in (-0.3, 0.3)
    ]
    a, b = np.arange(n), np.arange(n) + n
    c, d = np.append(a[1:], b[0]), np.append(b[1:], a[0])
    mesh = Mesh(np.vstack(rim), np.concatenate([np.stack([a, b, c], 1), np.stack([b, d, c], 1)]))
    assert clean(mesh).mesh is mesh


def test_pieces_can_be_chosen(small_mesh, sphere):
    both = Mesh(
        np.vstack([sphere.vertices / 10, small_mesh.vertices, [[9, 9, 9]]]),
        np.vstack([sphere.faces, small_mesh.faces + 2562]),
    )
    whole = mend(both)
    np.testing.assert_allclose(whole.piece_areas, [small_mesh.area, sphere.area / 100])
    assert whole.dropped == 0
    assert len(whole.mesh.vertices) == 3204
    assert np.bincount(whole.piece).tolist() == [642, 2562]
    assert_indices_agree(both, whole)
    small = keep(whole, [1])
    assert small.repairs[-1].startswith("kept number 2 of 2 components, 2,562 of 3,205 vertices, 0.")
    assert small.mesh.connectivity == sphere.connectivity
    assert small.dropped == pytest.approx(small_mesh.area / both.area)
    assert_indices_agree(both, small)
    assert (small.new_index[2562:] == -1).all()
    assert keep(whole, [0, 1]) is whole
    with pytest.raises(InputError, match="pieces: expected some of 0 to 1"):
        keep(whole, [2])


def test_a_mesh_without_area_is_refused():
    with pytest.raises(InputError, match="scan.ply: expected a mesh with a surface, all its 2 faces have zero area"):
        clean(Mesh(np.eye(3), [[0, 0, 1], [1, 2, 2]]), "scan.ply")


def assert_indices_agree(original, cleaned):
    assert np.array_equal(original.vertices[cleaned.vertex_index], cleaned.mesh.vertices)
    assert np.array_equal(cleaned.new_index[cleaned.vertex_index], np.arange(len(cleaned.mesh.vertices)))
