import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from lssd_learn.errors import InputError
from lssd_learn.exploration.template import landmark_means, template_log_ratio
from lssd_learn.shapes import Mesh


@pytest.fixture
def landmarks():
    """A function (size) → (n, 10, 3): one constellation turned and moved at will, of n sizes."""
    one = np.random.default_rng(0).normal(size=(10, 3))
    turns = Rotation.random(6, rng=np.random.default_rng(1)).as_matrix()
    return lambda sizes: np.stack([s * one @ turns[i] + i for i, s in enumerate(sizes)])


def test_means_know_sizes_and_not_places(landmarks):
    means, kept = landmark_means(landmarks([1, 1, 1, 2, 2, 2]), list("aaabbb"))
    assert kept.tolist() == list(range(10))
    np.testing.assert_allclose(2 * means["a"], means["b"], atol=1e-9)


def test_landmarks_at_one_place_count_once(landmarks):
    points = landmarks([1, 1, 2, 2])
    points[1, 7] = points[1, 3]
    means, kept = landmark_means(points, list("aabb"))
    assert kept.tolist() == [0, 1, 2, 3, 4, 5, 6, 8, 9]
    assert means["a"].shape == (9, 3)


def test_a_linear_change_is_exact(landmarks):
    """The spline of an affine map is that map: twice as large is four times the area, wherever the mesh lies."""
    ball = trimesh.creation.icosphere(2)
    mesh = Mesh(ball.vertices @ Rotation.random(rng=np.random.default_rng(2)).as_matrix() + 3, ball.faces)
    points = np.asarray(mesh.vertices[::20])
    first = (points - 3) @ Rotation.random(rng=np.random.default_rng(3)).as_matrix()
    np.testing.assert_allclose(template_log_ratio(mesh, points, first, 2 * first), np.log(4), atol=1e-8)
    np.testing.assert_allclose(template_log_ratio(mesh, points, first, first), 0, atol=1e-12)
    ratio = template_log_ratio(mesh, points, first, first * [1, 1, 1.5])
    np.testing.assert_allclose(template_log_ratio(mesh, points, first * [1, 1, 1.5], first), -ratio, atol=1e-8)


def test_a_local_change_stays_local():
    ball = trimesh.creation.icosphere(3)
    mesh = Mesh(ball.vertices, ball.faces)
    points = trimesh.creation.icosphere(1).vertices
    top = points[:, 2] > 0.8
    ratio = template_log_ratio(mesh, points, points, points + 0.3 * top[:, None] * points)
    assert mesh.vertices[np.abs(ratio).argmax(), 2] > 0.5
    assert np.abs(ratio[mesh.vertices[:, 2] < -0.5]).max() < 0.2 * np.abs(ratio).max()


@pytest.mark.parametrize(
    ("points", "labels", "message"),
    [
        (np.zeros((2, 5, 2)), "ab", r"landmarks: expected \(n, m, 3\) and n labels, got \(2, 5, 2\) and 2"),
        (np.zeros((2, 5, 3)), "abb", r"got \(2, 5, 3\) and 3"),
        (np.eye(3)[None].repeat(2, 0), "ab", "expected four or more that are apart on every shape, got 3"),
    ],
)
def test_bad_landmarks(points, labels, message):
    with pytest.raises(InputError, match=message):
        landmark_means(points, list(labels))
