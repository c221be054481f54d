"""Edges by their triangles: a map that is mirrored both ways undoes itself, and goes round no triangle."""

from itertools import combinations

import numpy as np
import pytest

from lssd_learn.latent.cycles import cycle_errors

K = 8
MIRROR = np.diag([1.0, -1] * K)


def network(n, bad=(), noise=0.0, seed=0):
    """(i, j) → orthogonal maps that agree, but for the pairs that are mirrored both ways."""
    rng = np.random.default_rng(seed)
    turns = [np.linalg.qr(rng.normal(size=(2 * K, 2 * K)))[0] for _ in range(n)]

    def maps(i, j):
        middle = MIRROR if (min(i, j), max(i, j)) in bad else np.eye(2 * K)
        return turns[j] @ middle @ turns[i].T + noise * rng.normal(size=(2 * K, 2 * K))

    return maps


@pytest.mark.parametrize("n", [4, 5, 30])
def test_only_the_edge_that_is_mirrored_both_ways_is_off(n):
    edges = list(combinations(range(n), 2))
    errors = dict(zip(edges, cycle_errors(np.array(edges), network(n, {(0, 2)}), K), strict=True))
    assert errors.pop((0, 2)) > 0.5
    assert max(errors.values()) < 1e-10


def test_an_edge_in_no_triangle_is_judged_by_its_two_maps():
    edges = np.array([[0, 1], [1, 2], [2, 3]])
    np.testing.assert_allclose(cycle_errors(edges, network(4, {(0, 1)}), K), 0, atol=1e-10)

    true = network(4)

    def maps(i, j):
        return true(i, j) @ (MIRROR if (i, j) == (1, 2) else np.eye(2 * K))

    assert np.flatnonzero(cycle_errors(edges, maps, K) > 1).tolist() == [1]


def test_one_direction_alone_counts():
    edges = np.array(list(combinations(range(5), 2)))

    true = network(5)

    def maps(i, j):
        return true(i, j) @ (MIRROR if (i, j) == (3, 1) else np.eye(2 * K))

    errors = cycle_errors(edges, maps, K)
    assert edges[errors > 0.5].tolist() == [[1, 3]]
