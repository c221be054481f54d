"""Shortest paths: never too short, and how much too long."""

import numpy as np
import pytest

from lssd_learn.shapes import Mesh, PointCloud
from lssd_learn.shapes.geodesics import geodesic_distances


def lattice(n):
    """n × n vertices of equilateral triangles with sides of 1."""
    i, j = np.divmod(np.arange(n * n), n)
    points = np.stack([j + i / 2, i * np.sqrt(3) / 2, np.zeros(n * n)], axis=1)
    a = np.flatnonzero((i < n - 1) & (j < n - 1))
    faces = np.concatenate([np.stack([a, a + 1, a + n], 1), np.stack([a + 1, a + n + 1, a + n], 1)])
    return Mesh(points, faces)


def test_on_equilateral_triangles_at_most_one_in_thirty_too_long():
    mesh = lattice(21)
    centre = np.full(441, 220)
    found = geodesic_distances(mesh, centre, np.arange(441))
    true = np.linalg.norm(mesh.vertices - mesh.vertices[220], axis=1)
    inside = (true > 0) & (true < 8)  # away from the border, whose triangles have no others across
    ratio = found[inside] / true[inside]
    assert ratio.min() > 1 - 1e-12
    assert 1.03 < ratio.max() < 1 / np.cos(np.pi / 12) + 1e-9


def test_across_an_edge_and_around_a_dent():
    """A straight line across the common edge, or around its end where it would leave the triangles."""
    flat = Mesh([[0, 0, 0], [1, 0, 0], [0.5, 1, 0], [0.5, -1, 0]], [[0, 1, 2], [1, 0, 3]])
    assert geodesic_distances(flat, [2], [3]) == pytest.approx(2)
    folded = Mesh([[0, 0, 0], [1, 0, 0], [0.5, 1, 0], [0.5, 0, 1]], [[0, 1, 2], [1, 0, 3]])
    assert geodesic_distances(folded, [2], [3]) == pytest.approx(2)
    dented = Mesh([[0, 0, 0], [1, 0, 0], [-1, 1, 0], [-1, -1, 0]], [[0, 1, 2], [1, 0, 3]])
    assert geodesic_distances(dented, [2], [3]) == pytest.approx(2 * np.sqrt(2))


def test_great_circles(sphere):
    rng = np.random.default_rng(0)
    starts, ends = rng.integers(0, 2562, (2, 50))
    true = np.arccos(np.clip(np.einsum("ix,ix->i", sphere.vertices[starts], sphere.vertices[ends]), -1, 1))
    ratio = geodesic_distances(sphere, starts, ends)[true > 0] / true[true > 0]
    assert ratio.min() > 0.995
    assert ratio.max() < 1.05


def test_one_after_the_other_or_together(small_mesh, monkeypatch):
    starts, ends = np.random.default_rng(0).integers(0, 642, (2, 30))
    together = geodesic_distances(small_mesh, starts, ends)
    monkeypatch.setattr("lssd_learn.shapes.geodesics.CHUNK", 2000)
    np.testing.assert_array_equal(geodesic_distances(small_mesh, starts, ends), together)
    np.testing.assert_allclose(geodesic_distances(small_mesh, ends, starts), together)
    assert geodesic_distances(small_mesh, [4], [4]) == 0


def test_clouds_and_pieces(small_mesh):
    cloud = PointCloud(small_mesh.vertices)
    along = geodesic_distances(small_mesh, [0] * 642, np.arange(642))
    among = geodesic_distances(cloud, [0] * 642, np.arange(642))
    assert np.abs(among[1:] / along[1:] - 1).max() < 0.2
    twice = Mesh(np.concatenate([small_mesh.vertices, small_mesh.vertices + 9]), np.concatenate(
        [small_mesh.faces, small_mesh.faces + 642]))  # fmt: skip
    assert geodesic_distances(twice, [0], [642]) == np.inf
