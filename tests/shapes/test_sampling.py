import numpy as np
import pytest

from lssd_learn.errors import InputError
from lssd_learn.shapes import Mesh, PointCloud, sample


def test_the_same_seed_gives_the_same_points(small_mesh):
    first, again, other = (sample(small_mesh, 100, np.random.default_rng(seed)) for seed in (0, 0, 1))
    assert np.array_equal(first, again)
    assert not np.array_equal(first, other)


def test_points_lie_on_the_surface(sphere):
    points = sample(sphere, 1000, np.random.default_rng(0))
    assert points.shape == (1000, 3)
    radius = np.linalg.norm(points, axis=1)
    assert radius.max() <= 1
    assert radius.min() > 0.99


def test_uniform_by_area():
    """Two triangles of areas 1 and 3: their shares, their centroids and their second moments."""
    mesh = Mesh([[0, 0, 0], [2, 0, 0], [0, 1, 0], [0, 0, 5], [6, 0, 5], [0, 1, 5]], [[0, 1, 2], [3, 4, 5]])
    points = sample(mesh, 100_000, np.random.default_rng(0))
    low = points[points[:, 2] < 1]
    assert len(low) / 100_000 == pytest.approx(0.25, abs=0.005)
    np.testing.assert_allclose(low.mean(axis=0), [2 / 3, 1 / 3, 0], atol=0.01)
    assert (low[:, 1] ** 2).mean() == pytest.approx(1 / 6, abs=0.003)


def test_a_cloud_gives_each_point_once_as_long_as_there_are_enough():
    cloud = PointCloud(np.arange(30.0).reshape(10, 3))
    few = sample(cloud, 7, np.random.default_rng(0))
    assert len(np.unique(few, axis=0)) == 7
    _, counts = np.unique(sample(cloud, 25, np.random.default_rng(0)), axis=0, return_counts=True)
    assert sorted(counts) == [2] * 5 + [3] * 5


def test_errors(small_mesh):
    with pytest.raises(InputError, match="n: expected at least 1 point, got 0"):
        sample(small_mesh, 0, np.random.default_rng(0))
    with pytest.raises(InputError, match="all its faces have zero area"):
        sample(Mesh(np.eye(3), [[0, 0, 1]]), 5, np.random.default_rng(0))
