"""Vertex maps and functional maps, there and back."""

import numpy as np
import pytest

from lssd_learn.maps import from_correspondence, to_vertices


def brute_force(source, target, C):
    """The nearest row, one after the other."""
    rows = target.evecs[:, : len(C)] @ C
    return np.array([((source.evecs[:, : C.shape[1]] - row) ** 2).sum(axis=1).argmin() for row in rows])


def test_an_exact_map_comes_back(twins):
    C = from_correspondence(twins.source, twins.target, twins.true)
    np.testing.assert_array_equal(to_vertices(twins.source, twins.target, C), twins.true)
    back = to_vertices(twins.target, twins.source, C.T)  # of an isometry the inverse is the transpose
    np.testing.assert_array_equal(back, np.argsort(twins.true))


def test_identity_is_identity(twins):
    np.testing.assert_array_equal(to_vertices(twins.source, twins.source, np.eye(50)), np.arange(615))


def test_it_is_the_nearest_row_for_any_map_of_any_size(bodies):
    C = np.random.default_rng(0).normal(size=(7, 9))
    expected = brute_force(bodies.source, bodies.target, C)
    np.testing.assert_array_equal(to_vertices(bodies.source, bodies.target, C), expected)


def test_a_map_of_too_many_functions_is_refused(twins):
    with pytest.raises(ValueError, match="C: expected at most 50 × 50 for these bases, got 51 × 50"):
        to_vertices(twins.source, twins.target, np.zeros((51, 50)))
