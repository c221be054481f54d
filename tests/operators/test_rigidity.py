"""Meshes moved as rigidly as given coefficients allow."""

import numpy as np
import pytest
from scipy.stats import special_ortho_group

from lssd_learn.collections import Bumps
from lssd_learn.measures.gram_quality import vertex_error
from lssd_learn.operators.rigidity import as_rigid_as_possible, moved_alike
from lssd_learn.shapes import Mesh, eigenbasis


@pytest.fixture(scope="module")
def mesh():
    sphere = Bumps(subdivisions=3)[2]
    return Mesh(sphere.vertices * [1, 1, 3], sphere.faces)


@pytest.fixture(scope="module")
def measure(mesh):
    basis = eigenbasis(mesh, 12)
    return basis.evecs.T * basis.mass


def test_a_turned_mesh_is_found_whole_from_its_smooth_part(mesh, measure):
    """Detail and all, from a start that has only moved, not turned."""
    turned = mesh.vertices @ special_ortho_group.rvs(3, random_state=0) + [3, 0, 1]
    basis = eigenbasis(mesh, 12)
    start = mesh.vertices + basis.evecs @ (measure @ (turned - mesh.vertices))
    assert np.abs(start - turned).max() > 0.05
    found = as_rigid_as_possible(mesh, measure, measure @ turned, start, rounds=40)
    np.testing.assert_allclose(found, turned, rtol=0, atol=1e-3)


def test_what_is_asked_is_met_and_edges_stay_nearer_than_by_moving(mesh, measure):
    """A bent mesh, of which the twelve smooth functions are known."""
    x, y, z = mesh.vertices.T
    bent = np.stack([x * np.cos(z / 2), y, z + x * np.sin(z / 2)], axis=1)
    basis = eigenbasis(mesh, 12)
    start = mesh.vertices + basis.evecs @ (measure @ (bent - mesh.vertices))
    found = as_rigid_as_possible(mesh, measure, measure @ bent, start)
    np.testing.assert_allclose(measure @ found, measure @ bent, atol=1e-9)
    a, b = mesh.faces[:, 0], mesh.faces[:, 1]
    lengths, *others = (np.linalg.norm(v[a] - v[b], axis=1) for v in (mesh.vertices, found, start))
    misfits = [np.mean((other - lengths) ** 2) for other in others]
    assert misfits[0] < 0.5 * misfits[1]


def test_a_mesh_moves_as_another_does():
    """Turned, it turns; bent, a longer one bends, and keeps its length."""
    mesh = Bumps(subdivisions=3)[2]
    a, c = (Mesh(mesh.vertices * [0.3, 0.3, length], mesh.faces) for length in (3, 4))
    R = special_ortho_group.rvs(3, random_state=0)
    turned = moved_alike(c, a.vertices, a.vertices @ R + 5)
    np.testing.assert_allclose(turned - turned.mean(0), (c.vertices - c.vertices.mean(0)) @ R, atol=1e-6)

    def bent(vertices, length):  # upon a half circle
        x, y, z = vertices.T
        angle = z / length
        return np.stack([(length + x) * np.cos(angle), y, (length + x) * np.sin(angle)], axis=1)

    truth = bent(c.vertices, 4)
    found = moved_alike(c, a.vertices, bent(a.vertices, 3))
    assert vertex_error(found, truth) < 0.05 * vertex_error(c.vertices, truth)
