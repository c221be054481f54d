import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from lssd_learn.collections.alignment.turns import angles_between, reached, shifts, sides, sparse_pairs, turns

N = 12


@pytest.fixture
def truth():
    """Poses of both determinants, the pairs of a network, and what each pair says of them without error."""
    rng = np.random.default_rng(0)
    P = Rotation.random(N, rng=rng).as_matrix() * np.where(np.arange(N) % 3, 1, -1)[:, None, None]
    u, pairs = rng.normal(size=(N, 3)), sparse_pairs(N)
    a, b = pairs.T
    Q = P[a] @ P[b].transpose(0, 2, 1)
    t = np.einsum("mx,mxy->my", u[a] - u[b], P[b].transpose(0, 2, 1))
    return P, u, pairs, Q, t


def gauge(P, found):
    """How far (n,) found poses are from true ones, up to one turn of all."""
    return angles_between(P.transpose(0, 2, 1) @ found, (P[0].T @ found[0])[None])


@pytest.mark.parametrize("n", [2, 3, 7, 8, 40])
def test_every_pair_stands_once_and_all_hold_together(n):
    pairs = sparse_pairs(n)
    assert (pairs[:, 0] < pairs[:, 1]).all()
    assert len(np.unique(pairs, axis=0)) == len(pairs) <= 3 * n or n < 8
    assert reached(n, pairs, np.ones(len(pairs), dtype=bool)).all()


def test_poses_come_back_from_what_pairs_say(truth):
    P, u, pairs, Q, t = truth
    found = turns(N, pairs, Q, np.ones(len(pairs)))
    assert gauge(P, found).max() < 1e-4
    moved = shifts(N, pairs, found, t, np.ones(len(pairs)))
    np.testing.assert_allclose((moved - moved[0]) @ found[0].T, (u - u[0]) @ P[0].T, atol=1e-6)


def test_one_pair_that_is_wrong_turns_nothing(truth):
    P, _, pairs, Q, _ = truth
    for wrong in range(len(pairs)):
        bad = Q.copy()
        bad[wrong] = bad[wrong] @ Rotation.from_rotvec([2, 0, 1]).as_matrix()
        assert gauge(P, turns(N, pairs, bad, np.ones(len(pairs)))).max() < 1


def test_noise_is_averaged(truth):
    P, _, pairs, Q, _ = truth
    noise = Rotation.from_rotvec(0.03 * np.random.default_rng(1).normal(size=(len(pairs), 3))).as_matrix()
    off = angles_between(Q, Q @ noise)
    found = turns(N, pairs, Q @ noise, np.ones(len(pairs)))
    assert np.median(gauge(P, found)[1:]) < np.median(off)


def test_sides_are_told_against_some_wrong_evidence():
    pairs = sparse_pairs(N)
    true = np.where(np.arange(N) % 3, 1, -1)
    evidence = (true[pairs[:, 0]] * true[pairs[:, 1]]).astype(float)
    evidence[::9] *= -0.5
    found = sides(N, pairs, evidence)
    assert (found * found[0] == true * true[0]).all()


def test_the_largest_piece_is_the_one_that_holds_together():
    pairs = np.array([[0, 1], [1, 2], [2, 3], [3, 4]])
    np.testing.assert_array_equal(reached(5, pairs, np.array([True, True, False, True])), [True] * 3 + [False] * 2)
