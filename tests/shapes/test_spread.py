"""Points spread out over a shape, and over a set of points."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

from lssd_learn.errors import InputError
from lssd_learn.shapes import PointCloud, sample
from lssd_learn.shapes.sampling import farthest_points, spread


def test_each_is_the_farthest_from_those_before():
    points = np.random.default_rng(0).normal(size=(60, 3))
    chosen = farthest_points(points, 12)
    assert chosen[0] == np.linalg.norm(points - points.mean(axis=0), axis=1).argmax()
    for i in range(1, 12):
        distance = np.linalg.norm(points[:, None] - points[chosen[:i]], axis=2).min(axis=1)
        assert chosen[i] == distance.argmax()
    np.testing.assert_array_equal(farthest_points(points, 5), chosen[:5])
    assert sorted(farthest_points(points, 60)) == list(range(60))


def test_the_order_of_the_points_does_not_matter():
    points, order = np.random.default_rng(0).normal(size=(60, 3)), np.random.default_rng(1).permutation(60)
    np.testing.assert_array_equal(order[farthest_points(points[order], 12)], farthest_points(points, 12))


def test_spread_points_lie_on_the_surface_farther_apart_than_random_ones(sphere):
    W = spread(sphere, 200, np.random.default_rng(0))
    assert W.shape == (200, 2562)
    np.testing.assert_allclose(W.sum(axis=1), 1)
    points = W @ sphere.vertices
    assert np.linalg.norm(points, axis=1).min() > 0.99
    gaps = [cKDTree(p).query(p, 2)[0][:, 1].min() for p in (points, sample(sphere, 200, np.random.default_rng(0)))]
    assert gaps[0] > 0.15 > 5 * gaps[1]


def test_their_density_does_not_depend_on_that_of_the_vertices(square):
    """Half of the cells are a hundred times smaller than the others."""
    mesh = square(10)
    x = mesh.vertices[:, 0]
    squeezed = type(mesh)(np.stack([np.where(x < 0.55, x * 0.1, (x - 0.5) * 1.9 + 0.05), *mesh.vertices.T[1:]], 1),
                          mesh.faces)  # fmt: skip
    points = spread(squeezed, 300, np.random.default_rng(0)) @ squeezed.vertices
    assert (points[:, 0] < 0.5).mean() == pytest.approx(0.5, abs=0.06)


def test_of_a_cloud_they_are_its_points(small_mesh):
    cloud = PointCloud(small_mesh.vertices)
    W = spread(cloud, 30, np.random.default_rng(0))
    np.testing.assert_array_equal(W @ cloud.points, cloud.points[farthest_points(cloud.points, 30)])


def test_errors(small_mesh):
    with pytest.raises(InputError, match="n: expected 1 to 642, the points there are, got 643"):
        spread(PointCloud(small_mesh.vertices), 643, np.random.default_rng(0))
    with pytest.raises(InputError, match="n: expected at least 1 point, got 0"):
        spread(small_mesh, 0, np.random.default_rng(0))
