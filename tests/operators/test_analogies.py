"""Laws of analogies, and what they mean for shapes."""

import numpy as np
import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st

from lssd_learn.errors import InputError
from lssd_learn.latent import LatentSpace, MapNetwork
from lssd_learn.operators import analogy, null_functions

METHODS = ["multiplicative", "log_euclidean"]


def close(actual, expected, atol=1e-8):
    torch.testing.assert_close(actual, expected, rtol=0, atol=atol)


@pytest.mark.parametrize("method", METHODS)
@given(m=st.integers(2, 6), null=st.booleans(), seed=st.integers(0, 10**6))
@settings(max_examples=25, deadline=None)
def test_of_two_equal_terms_the_third_comes_back(positive, conformal, method, m, null, seed):
    A, B, C = (conformal if null else positive)(3, m, seed)
    close(analogy(A, B, A, method), B)
    close(analogy(A, A, C, method), C)


@given(m=st.integers(2, 6), null=st.booleans(), seed=st.integers(0, 10**6))
@settings(max_examples=25, deadline=None)
def test_the_log_euclidean_one_is_symmetric_positive_definite(positive, conformal, m, null, seed):
    A, B, C = (conformal if null else positive)(3, m, seed)
    D = analogy(A, B, C, "log_euclidean")
    close(D, D.T)
    live = ~null_functions(D)
    assert int((~live).sum()) == null
    assert float(torch.linalg.eigvalsh(D[live][:, live]).min()) > 0
    close(D, analogy(A, C, B, "log_euclidean"))


@pytest.mark.parametrize("method", METHODS)
def test_with_nothing_truncated_areas_are_multiplied(untruncated, method):
    """Vertex by vertex: what made A's area B's makes C's that of the answer. The methods agree where all commute."""
    masses = np.random.default_rng(0).uniform(0.5, 2, (3, 6))
    A, B, C = torch.from_numpy(masses[:, :, None] * np.eye(6))
    close(analogy(A, B, C, method), torch.from_numpy(np.diag(masses[1] * masses[2] / masses[0])))


def test_the_multiplicative_one_is_the_papers_and_not_symmetric(positive):
    A, B, C = positive(3, 4)
    D = analogy(A, B, C)
    close(D, B @ torch.linalg.inv(A) @ C)
    assert float((D - D.T).abs().max()) > 0.1


def test_the_difference_between_two_shapes_is_an_analogy(truncated):
    """Functoriality, D_ij = Y_i D_i⁻¹ D_j Y_i⁻¹: i is to j as the latent shape, the identity, is to D_i⁻¹ D_j."""
    latent = LatentSpace.fit(MapNetwork.clique(truncated(6, 20)), 20, 20)
    area, _ = latent.differences()
    Y, C = latent.basis(1), latent.map(1, 4)
    through = analogy(area[1], torch.eye(20), area[4])
    close(Y @ through @ torch.linalg.inv(Y), C.T @ C, atol=1e-8 * float((C.T @ C).norm()))


def test_conformal_operators_that_are_not_symmetric_are_taken_without_the_constant(truncated):
    latent = LatentSpace.fit(MapNetwork.clique(truncated(6, 30)), 24, 10)
    _, (A, B, C, *_) = latent.differences()
    D = analogy(A, B, C)
    assert float(D[0].abs().max()) == float(D[:, 0].abs().max()) == 0
    close(D[1:, 1:], B[1:, 1:] @ torch.linalg.inv(A[1:, 1:]) @ C[1:, 1:])
    with pytest.raises(InputError, match="symmetric"):
        analogy(A, B, C, "log_euclidean")


def test_many_at_once(positive):
    A, B, C = positive(1, 4)[0], positive(5, 4, 1), positive(5, 4, 2)
    for method in METHODS:
        many = analogy(A, B, C, method)
        assert many.shape == (5, 4, 4)
        close(many[3], analogy(A, B[3], C[3], method))


def test_borders(positive):
    A, B, C = positive(3, 3)
    with pytest.raises(InputError, match="method='additive': expected multiplicative or log_euclidean"):
        analogy(A, B, C, "additive")
    with pytest.raises(InputError, match="A: expected an invertible operator"):
        analogy(torch.ones(3, 3), B, C)
    with pytest.raises(InputError, match="C: expected operators of 3 functions as the others, got 2"):
        analogy(A, B, torch.eye(2))
