import numpy as np
import pytest
import trimesh
from scipy.spatial import cKDTree

from lssd_learn.errors import InputError
from lssd_learn.learning.scores.reconstruction_scores import TrueSurface, sampling_level, vertex_error
from lssd_learn.nets import chamfer
from lssd_learn.shapes import Mesh, PointCloud, sample


@pytest.fixture(scope="module")
def square():
    """One square metre in the plane z = 0."""
    return Mesh([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]])


@pytest.fixture(scope="module")
def ball():
    """A closed surface of 1.26 m²."""
    sphere = trimesh.creation.icosphere(4, radius=0.3162)
    return Mesh(sphere.vertices, sphere.faces)


def cloud(mesh, n, seed):
    return PointCloud(sample(mesh, n, np.random.default_rng(seed)))


@pytest.mark.parametrize(("n", "m"), [(2000, 2000), (500, 4000)])
def test_two_samples_of_a_surface_are_at_the_sampling_level(ball, n, m):
    distances = [chamfer(cloud(ball, n, seed).points, cloud(ball, m, seed + 100).points) for seed in range(8)]
    assert np.mean(distances) == pytest.approx(sampling_level(ball.area, n, m), rel=0.04)


def test_the_level_of_a_body():
    assert sampling_level(1.9, 4096) == pytest.approx(2 * 1.9 / (np.pi * 4096))


def test_a_perfect_surface_scores_one(ball):
    truth = TrueSurface(ball, cloud(ball, 2000, 0).points)
    for shape in (cloud(ball, 2000, 1), ball):  # the mesh by 2,000 points of its own
        scores = truth.score(shape, seed=1)
        assert scores.cd_over_level == pytest.approx(1, rel=0.06)
        assert scores.cd == pytest.approx(scores.cd_over_level * sampling_level(ball.area, 2000))
    assert truth.score(ball, seed=1) == truth.score(cloud(ball, 2000, 1))


def test_recall_is_that_of_discs_around_the_points(square):
    """Of independent points a disc of radius r holds none with probability exp(−ρπr²)."""
    truth = TrueSurface(square, cloud(square, 2000, 0).points)
    scores = truth.score(cloud(square, 2000, 1))
    for length, f in ((0.01, scores.f_1cm), (0.02, scores.f_2cm)):
        recall = 1 - np.exp(-2000 * np.pi * length**2)
        assert f == pytest.approx(2 * recall / (1 + recall), abs=0.03)


def test_precision_counts_the_points_near_the_surface(square):
    """Dense points hover at heights from 0 to 4 cm, and dense points on the surface make recall 1."""
    truth, n = TrueSurface(square, cloud(square, 100, 0).points), 20_000
    hovering = np.hstack([cloud(square, n, 1).points[:, :2], np.random.default_rng(2).uniform(0, 0.04, (n, 1))])
    scores = truth.score(PointCloud(np.vstack([cloud(square, n, 3).points, hovering])))
    for length, f in ((0.01, scores.f_1cm), (0.02, scores.f_2cm)):
        precision = (1 + length / 0.04) / 2
        assert f == pytest.approx(2 * precision / (1 + precision), abs=0.003)


def test_what_is_far_away_scores_nothing(ball):
    truth = TrueSurface(ball, cloud(ball, 200, 0).points, samples=1000)
    scores = truth.score(PointCloud(cloud(ball, 200, 1).points + 5))
    assert (scores.f_1cm, scores.f_2cm) == (0, 0)
    assert scores.cd > 30
    assert set(vars(scores)) == {"cd", "cd_over_level", "f_1cm", "f_2cm"}


def test_the_whole_may_be_moved(ball):
    def scores(shift):
        moved = Mesh(ball.vertices + shift, ball.faces)
        truth = TrueSurface(moved, cloud(moved, 500, 0).points, samples=5000)
        return list(vars(truth.score(PointCloud(cloud(moved, 500, 1).points + [0.005, 0, 0]))).values())

    np.testing.assert_allclose(scores(np.array([1.0, -2, 3])), scores(np.zeros(3)), rtol=1e-3)


def test_vertex_error():
    truth = np.zeros((2, 5, 3))
    assert vertex_error(truth, truth) == 0
    assert vertex_error(truth + [0, 3, 4], truth) == 5
    assert vertex_error(np.stack([truth[0], truth[1] + [1, 0, 0]]), truth) == 0.5


def test_errors(ball):
    with pytest.raises(InputError, match="mesh: expected a surface to compare with, got a PointCloud"):
        TrueSurface(cloud(ball, 10, 0), np.zeros((10, 3)))
    with pytest.raises(InputError, match=r"vertices: expected .* got \(4, 3\) and \(5, 3\)"):
        vertex_error(np.zeros((4, 3)), np.zeros((5, 3)))
    with pytest.raises(InputError, match="n=0"):
        sampling_level(1.0, 0)


def test_precision_allows_for_the_spacing_of_the_samples(square):
    """Few samples: a point of the surface lies farther from the nearest than 2 cm, and yet is precise."""
    truth = TrueSurface(square, cloud(square, 100, 0).points, samples=400)  # area / (π 400) = (2.8 cm)²
    on_it = cloud(square, 4000, 1).points
    distance = truth.surface.distances(on_it)
    plain, allowed = np.mean(distance <= 0.02), np.mean(distance**2 <= 0.02**2 + square.area / (np.pi * 400))
    assert plain < 0.5 < allowed
    recall = np.mean(cKDTree(on_it).query(truth.surface.points)[0] <= 0.02)
    assert truth.score(PointCloud(on_it)).f_2cm == pytest.approx(2 * allowed * recall / (allowed + recall))
