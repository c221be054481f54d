"""Maps from landmarks: exact between copies, near the truth between bodies of two connectivities."""

import numpy as np
import pytest

from lssd_learn.errors import InputError
from lssd_learn.maps import euclidean_errors, flipped, from_correspondence, landmarks
from lssd_learn.maps.landmarks import commuting, landmark_vertices
from lssd_learn.shapes import Mesh, eigenbasis


def ends(pair):
    return pair.source, pair.target, pair.source_landmarks, pair.target_landmarks


def test_a_shuffled_copy_is_recovered(twins):
    np.testing.assert_array_equal(landmark_vertices(*ends(twins)), twins.true)
    expected = from_correspondence(twins.source, twins.target, twins.true)
    np.testing.assert_allclose(landmarks(*ends(twins)), expected, atol=1e-12)


@pytest.mark.parametrize("marks", [8, 5])
def test_bodies_of_two_connectivities(bodies, marks):
    some = bodies.source_landmarks[:marks], bodies.target_landmarks[:marks]
    found = landmark_vertices(bodies.source, bodies.target, *some)
    assert euclidean_errors(bodies.source_shape, found, bodies.true).mean() < 0.025
    assert flipped(bodies.side, found, bodies.true) < 0.01


def test_neither_the_unit_of_length_nor_a_rigid_motion_matters(bodies):
    turn = np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))[0]
    shape = bodies.target_shape
    other = eigenbasis(Mesh(1000 * shape.vertices @ turn + 5, shape.faces), 60)
    found = landmark_vertices(bodies.source, other, bodies.source_landmarks, bodies.target_landmarks)
    assert (found == landmark_vertices(*ends(bodies))).mean() > 0.99


def test_every_row_is_a_least_squares_solution():
    rng = np.random.default_rng(0)
    A, B, s, t = rng.normal(size=(5, 9)), rng.normal(size=(4, 9)), np.arange(5.0) ** 2, 3.0 * np.arange(4)
    C = commuting(A, B, s, t, 0.3)
    gap = (t[:, None] - s) ** 2
    for a in range(4):
        root = np.diag(np.sqrt(0.3 * gap[a] / gap.max()))
        left, right = np.vstack([A.T, root]), np.concatenate([B[a], np.zeros(5)])
        expected = np.linalg.lstsq(left[:, 1:], right - left[:, 0] * (a == 0))[0]
        np.testing.assert_allclose(C[a], [a == 0, *expected], atol=1e-10)


def test_a_single_function_is_the_constant():
    np.testing.assert_array_equal(
        commuting(np.ones((1, 3)), np.ones((2, 3)), np.zeros(1), np.arange(2.0), 1), [[1], [0]]
    )


def test_what_does_not_fit_is_refused(twins):
    pair = twins.source, twins.target
    with pytest.raises(InputError, match="landmarks: expected as many on both shapes, got 2 and 3"):
        landmarks(*pair, [0, 1], [0, 1, 2])
    with pytest.raises(InputError, match="landmarks: expected vertices, 0 to 614, got 615"):
        landmarks(*pair, [0, 615], [0, 1])
    with pytest.raises(InputError, match="functions=0: expected a whole number, 1 or more"):
        landmarks(*pair, [0, 1], [0, 1], functions=0)
