import numpy as np
from scipy.spatial.transform import Rotation

from lssd_learn.shapes.kabsch import kabsch, nearest_orthogonal, nearest_rotation


def test_the_turn_is_found_for_many_sets_at_once():
    rng = np.random.default_rng(0)
    points, turns = rng.normal(size=(5, 20, 3)), Rotation.random(5, rng=rng).as_matrix()
    np.testing.assert_allclose(kabsch(points, points @ turns), turns, atol=1e-12)


def test_weights_say_what_counts():
    rng = np.random.default_rng(0)
    points, turn = rng.normal(size=(20, 3)), Rotation.from_rotvec([1, 2, 0.5]).as_matrix()
    goals = np.concatenate([points[:10] @ turn, rng.normal(size=(10, 3))])
    np.testing.assert_allclose(kabsch(points, goals, np.arange(20) < 10), turn, atol=1e-12)


def test_it_agrees_with_scipy():
    rng = np.random.default_rng(1)
    points, goals, weights = rng.normal(size=(30, 3)), rng.normal(size=(30, 3)), rng.random(30)
    oracle = Rotation.align_vectors(goals, points, weights)[0].as_matrix()
    np.testing.assert_allclose(kabsch(points, goals, weights), oracle.T, atol=1e-10)


def test_a_mirror_image_is_turned_and_not_mirrored():
    points = np.random.default_rng(0).normal(size=(20, 3))
    assert np.linalg.det(kabsch(points, -points)) > 0
    np.testing.assert_allclose(nearest_orthogonal(-points.T @ points), -np.eye(3), atol=1e-12)
    assert np.linalg.det(nearest_rotation(-points.T @ points)) > 0
