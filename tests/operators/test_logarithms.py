"""Logarithms against scipy's, and there and back."""

import numpy as np
import pytest
import scipy.linalg
import torch
from hypothesis import given, settings
from hypothesis import strategies as st

from lssd_learn.errors import InputError
from lssd_learn.latent import LatentSpace, MapNetwork
from lssd_learn.operators import exponential, log_eigenvalues, logarithm, null_functions


def test_they_are_scipys(positive):
    D = positive(4, 5)
    expected = np.stack([scipy.linalg.logm(X.numpy()) for X in D])
    np.testing.assert_allclose(logarithm(D).numpy(), expected, atol=1e-9)
    expected = np.stack([scipy.linalg.expm(X.numpy()) for X in D])
    np.testing.assert_allclose(exponential(D).numpy(), expected, rtol=1e-9)


@given(n=st.integers(0, 4), m=st.integers(2, 6), null=st.booleans(), seed=st.integers(0, 10**6))
@settings(max_examples=40, deadline=None)
def test_the_exponential_brings_every_operator_back(positive, conformal, n, m, null, seed):
    D = (conformal if null else positive)(n, m, seed)
    logs = logarithm(D)
    torch.testing.assert_close(logs, logs.mT)
    torch.testing.assert_close(exponential(logs, null_functions(D)), D)
    spectra = log_eigenvalues(D)
    assert spectra.shape == (n, m - (null and n > 0))
    torch.testing.assert_close(spectra.sum(-1), logs.diagonal(dim1=-2, dim2=-1).sum(-1))


def test_null_functions_are_left_out_and_zero(conformal, positive):
    D = conformal(3, 5)
    assert null_functions(D).tolist() == [True, False, False, False, False]
    assert float(logarithm(D)[:, 0].abs().max()) == 0
    torch.testing.assert_close(logarithm(D)[:, 1:, 1:], logarithm(D[:, 1:, 1:]))
    assert not null_functions(positive(2, 5)).any()
    assert not null_functions(D, positive(2, 5)).any()  # live in one of them
    assert exponential(logarithm(D))[0, 0, 0] == 1


def test_null_functions_of_real_operators(truncated):
    latent = LatentSpace.fit(MapNetwork.clique(truncated(6, 30)), 24, 12)
    for symmetric in (False, True):
        area, conformal = latent.differences(symmetric)
        assert not null_functions(area).any()
        assert null_functions(conformal).tolist() == [True] + 11 * [False]
    assert null_functions(conformal.float()).tolist() == [True] + 11 * [False]
    torch.testing.assert_close(exponential(logarithm(conformal), null_functions(conformal)), conformal)


def test_identical_shapes_have_the_logarithm_zero():
    assert float(logarithm(torch.eye(4)).abs().max()) == 0
    torch.testing.assert_close(exponential(torch.zeros(4, 4)), torch.eye(4, dtype=torch.float64))


@pytest.mark.parametrize(
    ("D", "message"),
    [
        ([[1.0, 2.0], [0.0, 1.0]], "D: expected symmetric operators"),
        (
            [[1.0, 2.0], [2.0, 1.0]],
            "D: expected positive definite operators, got an eigenvalue of -1 beside a largest of 3",
        ),
        ([[1.0, 1.0], [1.0, 1.0]], "positive definite"),
        ([[-1.0, 0.0], [0.0, -2.0]], "positive definite"),
        ([[0.0, 0.0], [0.0, 0.0]], "nothing but null functions"),
        ([[[1.0, 0.0], [0.0, 1.0]], [[1.0, 0.0], [0.0, 0.0]]], "positive definite"),
        ([1.0, 2.0], r"expected operators \(…, m, m\)"),
    ],
)
def test_what_has_no_logarithm_is_refused(D, message):
    for function in (logarithm, log_eigenvalues):
        with pytest.raises(InputError, match=message):
            function(np.array(D))


def test_a_mask_of_null_functions_must_fit():
    with pytest.raises(InputError, match="null: expected a bool for each of 2 functions"):
        exponential(np.eye(2), torch.tensor([True]))
    with pytest.raises(InputError, match="X: expected symmetric"):
        exponential(np.array([[0.0, 1.0], [0.0, 0.0]]))
