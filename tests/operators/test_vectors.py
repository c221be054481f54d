"""Logarithms as vectors against scipy's, what rounding does to them, and the functions that are left out."""

import numpy as np
import pytest
import scipy.linalg
import torch

from lssd_learn.errors import InputError
from lssd_learn.operators.vectors import entries, live_functions, log_features, log_vectors, shape_variables


@pytest.fixture
def operators():
    X = torch.randn(5, 4, 7, generator=torch.Generator().manual_seed(0), dtype=torch.float64)
    return X @ X.mT


def test_entries_keep_inner_products(operators):
    vectors = entries(operators)
    assert vectors.shape == (5, 10)
    assert torch.allclose(vectors @ vectors.T, torch.einsum("aij,bij->ab", operators, operators))


def test_logarithms_are_scipys_and_keep_inner_products(operators):
    logs = torch.stack([torch.from_numpy(scipy.linalg.logm(D.numpy())) for D in operators])
    vectors = log_vectors(operators)
    assert vectors.shape == (5, 10)
    assert torch.allclose(vectors @ vectors.T, torch.einsum("aij,bij->ab", logs, logs))


def test_logarithms_do_not_amplify_rounding(operators):
    evals, V = torch.linalg.eigh(operators[0])
    evals[0] = -1e-8 * evals[-1]  # what float32 may make of zero
    assert log_vectors((V * evals @ V.T)[None]).norm() < 50


@pytest.mark.parametrize(
    ("matrix", "message"),
    [
        ([[1.0, 2.0], [0.0, 1.0]], "symmetric"),
        ([[1.0, 2.0], [2.0, 1.0]], "positive"),
        ([[0.0]], "positive"),
    ],
)
def test_what_has_no_logarithm_is_refused(matrix, message):
    with pytest.raises(InputError, match=message):
        log_vectors(torch.tensor([matrix]))


def test_null_functions_of_all_shapes_are_left_out_of_their_channel_and_the_gauge_is_ignored(operators):
    padded = torch.zeros(5, 1, 5, 5, dtype=torch.float64)
    padded[:, 0, 1:, 1:] = operators
    both = torch.cat([padded, torch.eye(5).expand(5, 1, 5, 5)], 1)
    live = live_functions(both)
    assert live.tolist() == [[False, True, True, True, True], [True] * 5]
    features = log_features(both, live)
    assert features.shape == (5, 10 + 15)
    Q = torch.linalg.qr(operators[0])[0]
    plain, turned = (log_vectors(D) for D in (operators, Q.T @ operators @ Q))
    np.testing.assert_allclose(features @ features.T, plain @ plain.T, atol=1e-8)
    np.testing.assert_allclose(turned @ turned.T, plain @ plain.T, atol=1e-8)


def test_of_no_shape_and_of_no_function_there_is_nothing():
    assert log_vectors(torch.zeros(0, 3, 3)).shape == (0, 6)
    assert log_vectors(torch.zeros(2, 0, 0)).shape == (2, 0)


def test_variables_are_the_logarithms_by_name(operators):
    """Those of scipy, entry by entry; a null function has no column, nor has a kind that is not positive."""
    null = operators.clone()
    null[:, 1] = null[:, :, 1] = 0
    columns = shape_variables(torch.stack([null, -operators, operators], 1), ["a", "b", "c"])
    rest = [0, 2, 3]
    assert list(columns)[:6] == [f"a_{i + 1}_{j + 1}" for i in rest for j in rest if i <= j]
    assert len(columns) == 6 + 10
    for k, D in enumerate(operators.numpy()):
        whole, less = scipy.linalg.logm(D), scipy.linalg.logm(D[np.ix_(rest, rest)])
        assert columns["c_2_4"][k] == pytest.approx(2**0.5 * whole[1, 3])
        assert columns["a_3_3"][k] == pytest.approx(less[1, 1])
    table = torch.stack([values for name, values in columns.items() if name[0] == "c"], 1)
    assert torch.allclose(table, log_vectors(operators))
