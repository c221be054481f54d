import numpy as np
import pytest
import trimesh

from lssd_learn.models.measuring.even import even
from lssd_learn.shapes import Mesh, PointCloud


@pytest.fixture(scope="module")
def half_fine():
    """A sphere of which the upper half has sixteen times as many triangles."""
    ball = trimesh.creation.icosphere(4)
    vertices, faces = ball.vertices, ball.faces
    for _ in range(2):
        upper = np.flatnonzero(vertices[faces][:, :, 2].mean(axis=1) > 0)
        vertices, faces = trimesh.remesh.subdivide(vertices, faces, face_index=upper)
    return Mesh(np.asarray(vertices), np.asarray(faces))


@pytest.mark.parametrize("cloud", [False, True])
def test_half_of_a_surface_has_half_of_the_points_however_fine_it_is(half_fine, cloud):
    points = half_fine.vertices
    assert (points[:, 2] > 0).mean() > 0.85
    shape = PointCloud(0.2 * points) if cloud else half_fine
    found = even(shape, 300, np.random.default_rng(0))
    assert len(np.unique(found)) == len(found) <= 300
    assert (points[found, 2] > 0).mean() < 0.65


def test_points_that_are_too_few_are_all_taken():
    cloud = PointCloud(np.random.default_rng(0).normal(size=(50, 3)))
    assert sorted(even(cloud, 100, np.random.default_rng(1))) == list(range(50))
