"""Meshes whose detail turns."""

import numpy as np
import pytest
from scipy.stats import special_ortho_group

from lssd_learn.collections import Bumps
from lssd_learn.operators.rigidity import moved_alike, with_turned_detail
from lssd_learn.shapes import Mesh, eigenbasis
from lssd_learn.shapes.kabsch import vertex_error


@pytest.fixture(scope="module")
def mesh():
    sphere = Bumps(subdivisions=3)[2]
    return Mesh(sphere.vertices * [1, 1, 3], sphere.faces)


@pytest.fixture(scope="module")
def measure(mesh):
    basis = eigenbasis(mesh, 12)
    return basis.evecs.T * basis.mass


@pytest.fixture(scope="module")
def smooth(mesh, measure):
    """A function vertices → their smooth part."""
    functions = eigenbasis(mesh, 12).evecs
    return lambda vertices: functions @ (measure @ vertices)


def test_a_turned_mesh_is_found_whole_from_its_smooth_part(mesh, measure, smooth):
    """Detail and all, where the move of its smooth part alone leaves the detail as it stood."""
    turned = mesh.vertices @ special_ortho_group.rvs(3, random_state=0) + [3, 0, 1]
    before, after = smooth(mesh.vertices), smooth(turned)
    assert np.abs(mesh.vertices + after - before - turned).max() > 0.05
    found = with_turned_detail(mesh, before, after, measure, rounds=40)
    np.testing.assert_allclose(found, turned, rtol=0, atol=1e-3)


def test_a_bent_mesh_has_its_smooth_part_and_is_nearer_than_by_moving(mesh, measure, smooth):
    bent = upon_a_circle(mesh.vertices, 3)
    before, after = smooth(mesh.vertices), smooth(bent)
    found = with_turned_detail(mesh, before, after, measure)
    np.testing.assert_allclose(measure @ found, measure @ bent, atol=1e-9)
    assert vertex_error(found, bent) < 0.7 * vertex_error(mesh.vertices + after - before, bent)


def upon_a_circle(vertices, length):
    x, y, z = vertices.T
    return np.stack([(length + x) * np.cos(z / length), y, (length + x) * np.sin(z / length)], axis=1)


def test_a_mesh_moves_as_another_does():
    """Turned, it turns; bent, a longer one bends, and keeps its length."""
    mesh = Bumps(subdivisions=3)[2]
    a, c = (Mesh(mesh.vertices * [0.3, 0.3, length], mesh.faces) for length in (3, 4))
    R = special_ortho_group.rvs(3, random_state=0)
    turned = moved_alike(c, a.vertices, a.vertices @ R + 5)
    np.testing.assert_allclose(turned - turned.mean(0), (c.vertices - c.vertices.mean(0)) @ R, atol=1e-6)

    truth = upon_a_circle(c.vertices, 4)
    found = moved_alike(c, a.vertices, upon_a_circle(a.vertices, 3))
    assert vertex_error(found, truth) < 0.05 * vertex_error(c.vertices, truth)


def test_what_moves_as_itself_ends_where_it_ends(mesh):
    """Stretches are handed on too; triangles without area say nothing."""
    rng = np.random.default_rng(0)
    after = upon_a_circle(mesh.vertices * [1, 2, 1], 3) + 0.01 * rng.normal(size=mesh.vertices.shape)
    found = moved_alike(mesh, mesh.vertices, after)
    np.testing.assert_allclose(found - found.mean(0), after - after.mean(0), atol=1e-5)
    collapsed = mesh.vertices.copy()
    collapsed[mesh.faces[0]] = collapsed[mesh.faces[0, 0]]
    assert np.isfinite(moved_alike(mesh, collapsed, after)).all()
