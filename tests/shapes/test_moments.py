"""The form of all pairs of points against the sum over all pairs, and what it and the coordinates do under motions."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import ortho_group

from lssd_learn.shapes import PointCloud, eigenbasis
from lssd_learn.shapes.moments import moments


def pairs(x, m, F):
    """Σ_ab w_ab (f_a − f_b)(g_a − g_b) / Σ_ab w_ab, w_ab = m_a m_b ‖x_a − x_b‖², of all functions F, as it stands."""
    weights = m[:, None] * m * np.square(x[:, None] - x).sum(-1)
    apart = F[:, None] - F
    return np.einsum("ab,abf,abg->fg", weights, apart, apart) / weights.sum()


def some(seed, V=20, k=6):
    """Points, masses and any functions, the first constant."""
    rng = np.random.default_rng(seed)
    F = rng.normal(size=(V, k))
    F[:, 0] = 2
    return rng.normal(size=(V, 3)) * rng.uniform(0.1, 3, 3) + rng.normal(size=3), rng.uniform(0.1, 1, V), F


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 10**6))
def test_the_closed_form_is_the_sum_over_all_pairs(seed):
    x, m, F = some(seed)
    found, brute = moments(x, m, F).form, pairs(x, m, F)
    np.testing.assert_allclose(found, brute, rtol=0, atol=1e-12 * np.abs(brute).max())
    assert np.array_equal(found, found.T)


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 10**6), st.floats(0.1, 10))
def test_motions_leave_the_form_and_turn_the_coordinates(seed, s):
    x, m, F = some(seed)
    R, before = ortho_group.rvs(3, random_state=seed), moments(x, m, F)  # reflections too
    after = moments(x @ R + 1000, m, F)
    np.testing.assert_allclose(after.form, before.form, rtol=0, atol=1e-9 * np.abs(before.form).max())
    np.testing.assert_allclose(after.coordinates, before.coordinates @ R, rtol=0, atol=1e-8)
    np.testing.assert_allclose(moments(s * x, s**2 * m, F).form, before.form, rtol=1e-7, atol=1e-9)


def test_the_constant_is_null_and_nothing_else_is_small():
    """On functions of mean zero E lies between 1 and 3 + max q / Q times Σ μ f²."""
    x, m, F = some(3)
    m = m / m.sum()
    found = moments(x, m, F)
    size = np.abs(found.form).max()
    np.testing.assert_allclose(found.form[0], 0, atol=1e-12 * size)
    np.testing.assert_allclose(found.coordinates[0], 0, atol=1e-12)
    q = np.square(x - m @ x).sum(1)
    F = F[:, 1:] - m @ F[:, 1:]
    evals = np.linalg.eigvals(np.linalg.solve(F.T @ (m[:, None] * F), moments(x, m, F).form)).real
    assert evals.min() >= 1 - 1e-12
    assert evals.max() <= 3 + q.max() / (m @ q)


@pytest.mark.parametrize("kind", ["mesh", "cloud"])
def test_those_of_an_eigenbasis(meshes, kind):
    shape = meshes[0] if kind == "mesh" else PointCloud(meshes[0].vertices)
    basis = eigenbasis(shape, 12)
    brute = pairs(shape.vertices, basis.mass, basis.evecs)
    np.testing.assert_allclose(basis.moments.form, brute, rtol=0, atol=1e-10 * np.abs(brute).max())
    few = basis.truncate(5).moments
    assert np.array_equal(few.form, basis.moments.form[:5, :5])
    assert few.coordinates.shape == (5, 3)
