"""A shape in every form a person may have it in."""

import logging

import numpy as np
import pytest
import torch
import trimesh

from lssd_learn.collections import eigenbases
from lssd_learn.errors import InputError
from lssd_learn.shapes import Mesh, PointCloud, as_shape, eigenbasis, load, save
from lssd_learn.shapes.given import content_key, is_one


def test_a_mesh_is_a_mesh_in_any_form(meshes, tmp_path):
    mesh = meshes[0]
    save(mesh, tmp_path / "mesh.off")
    theirs = trimesh.Trimesh(mesh.vertices, mesh.faces, process=False)
    pairs = [(mesh.vertices, mesh.faces), [mesh.vertices.tolist(), mesh.faces.tolist()]]
    pairs.append((torch.tensor(mesh.vertices), torch.tensor(mesh.faces)))
    for given in (mesh, theirs, *pairs, tmp_path / "mesh.off", str(tmp_path / "mesh.off")):
        shape = as_shape(given)
        assert content_key(shape) == content_key(mesh)
        np.testing.assert_array_equal(eigenbasis(given, 5).evals, eigenbasis(mesh, 5).evals)
    assert as_shape(mesh) is mesh


def test_points_alone_are_a_cloud(meshes):
    for given in (meshes[0].vertices, trimesh.PointCloud(meshes[0].vertices), torch.tensor(meshes[0].vertices)):
        assert isinstance(as_shape(given), PointCloud)
        assert is_one(given)


def test_a_file_is_cleaned_and_the_log_says_so(meshes, tmp_path, caplog):
    far = np.array([[9.0, 0, 0], [9, 1, 0], [9, 0, 1]])
    dirty = Mesh(np.vstack([meshes[0].vertices, far]), np.vstack([meshes[0].faces, [[162, 163, 164]]]))
    save(dirty, tmp_path / "dirty.off")
    with caplog.at_level(logging.INFO):
        shape = as_shape(tmp_path / "dirty.off")
    assert len(shape.vertices) == 162
    assert "dirty.off: " in caplog.text


@pytest.mark.parametrize(
    ("given", "message"),
    [
        (7, "hips: expected a Mesh, a PointCloud, .* or a path, got int"),
        (np.zeros((4, 2)), r"hips: expected a Mesh, .* got ndarray of shape \(4, 2\)"),
        ((np.zeros((4, 3)), np.zeros((2, 4), int)), "hips: expected a Mesh, .* got tuple"),
        ((np.zeros((4, 3)), np.full((2, 3), 9)), "hips: faces: expected indices from 0 to 3, got some from 9 to 9"),
        (np.full((4, 3), np.nan), "hips: points: expected finite coordinates"),
        ("nowhere.ply", "nowhere.ply: no such file"),
    ],
)
def test_anything_else_is_told(given, message):
    with pytest.raises(InputError, match=message):
        as_shape(given, "hips")


def test_the_content_tells_shapes_apart(meshes):
    mesh = meshes[0]
    cloud, turned = PointCloud(mesh.vertices), Mesh(mesh.vertices, np.roll(mesh.faces, 1, axis=1))
    moved = Mesh(mesh.vertices + np.eye(162, 3) * 1e-12, mesh.faces)
    assert len({content_key(shape) for shape in (mesh, meshes[1], cloud, turned, moved)}) == 5
    assert content_key(Mesh(mesh.vertices.copy(), mesh.faces.copy())) == content_key(mesh)


def slit(mesh):
    """Half of the vertices between two halves twice, as along the seam of a texture: one piece all the time."""
    beyond = mesh.vertices[mesh.faces].mean(axis=1)[:, 0] > 0
    shared = np.intersect1d(mesh.faces[beyond], mesh.faces[~beyond])
    shared = shared[mesh.vertices[shared, 1] < 0]
    number = np.arange(len(mesh.vertices))
    number[shared] = len(mesh.vertices) + np.arange(len(shared))
    return np.vstack([mesh.vertices, mesh.vertices[shared]]), np.where(beyond[:, None], number[mesh.faces], mesh.faces)


def test_a_seam_is_closed_in_a_file_and_told_of_arrays(meshes, tmp_path, caplog):
    vertices, faces = slit(meshes[0])
    double = len(vertices) - len(meshes[0].vertices)
    save(Mesh(vertices, faces), tmp_path / "slit.ply")
    truth = eigenbasis(meshes[0], 5).evals
    np.testing.assert_allclose(eigenbasis(tmp_path / "slit.ply", 5).evals, truth, rtol=1e-9, atol=1e-12)
    assert not caplog.messages
    for given in (load(tmp_path / "slit.ply"), (vertices, faces), trimesh.Trimesh(vertices, faces, process=False)):
        assert eigenbasis(given, 5).evals[1] < 0.98 * truth[1]
        assert f"shape: {double} border vertices where others are" in caplog.messages[-1]
        eigenbases([*meshes[:2], given, given], 5, cache=None, workers=1)
        assert caplog.messages[-1].startswith("2 of 4 shapes (shapes[2], shapes[3]), the first: ")
    assert len(caplog.messages) == 6


def test_faces_that_are_there_twice_are_told(meshes, caplog):
    eigenbasis((meshes[0].vertices, np.vstack([meshes[0].faces, meshes[0].faces[:7]])), 5)
    assert caplog.messages == ["shape: 7 faces given twice: taken as it is; clean(mesh).mesh is mended"]
