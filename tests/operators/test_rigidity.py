"""Meshes moved as rigidly as given coefficients allow."""

import numpy as np
import pytest
from scipy.stats import special_ortho_group

from lssd_learn.collections import Bumps
from lssd_learn.operators.rigidity import as_rigid_as_possible
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
