"""A blend of two operators: either of them at the ends, exact where nothing is truncated, positive definite always."""

import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st

from lssd_learn.errors import InputError
from lssd_learn.operators import blend, localise

SIZES = {"m": st.integers(1, 7), "seed": st.integers(0, 10**6)}


def close(actual, expected, atol=1e-8):
    torch.testing.assert_close(actual, expected.expand_as(actual), rtol=0, atol=atol)


def some_region(functions, m, seed):
    """Symmetric, with a spectrum in [0, 1]."""
    V = functions(m, m, seed)
    return (V * torch.rand(m, generator=torch.Generator().manual_seed(seed), dtype=V.dtype)) @ V.T


@given(**SIZES)
@settings(max_examples=30, deadline=None)
def test_nothing_everything_and_the_complement(positive, functions, m, seed):
    A, B = positive(4, m, seed).split(2)
    R, one = some_region(functions, m, seed), torch.eye(m, dtype=A.dtype)
    close(blend(A, B, 0 * one), A)
    close(blend(A, B, one), B)
    close(blend(A, A, R), A)
    close(blend(A, B, R), blend(B, A, one - R))


@given(**SIZES)
@settings(max_examples=30, deadline=None)
def test_symmetric_positive_definite(positive, functions, m, seed):
    A, B = positive(6, m, seed, spread=4.0).split(3)
    D = blend(A, B, some_region(functions, m, seed))
    close(D, D.mT)
    assert (torch.linalg.eigvalsh(D) > 0).all()


def test_where_all_commute_it_is_the_localisation(positive, functions):
    """As multiplications by functions do, which area operators are where nothing is truncated."""
    a, b = torch.rand(2, 6, dtype=torch.float64) + 0.5
    V = functions(6, 6, 0)
    A, B = (V * a) @ V.T, (V * b) @ V.T
    F = V[:, :2]
    close(blend(A, B, F @ F.T), localise(A, B, F))


def test_null_functions_stay_null(positive, functions):
    A, B = torch.zeros(2, 5, 5, dtype=torch.float64)
    A[1:, 1:], B[1:, 1:] = positive(2, 4, 0)
    R = some_region(functions, 5, 0)
    D = blend(A, B, R)
    assert (D[0] == 0).all()
    assert (D[:, 0] == 0).all()
    close(D[1:, 1:], blend(A[1:, 1:], B[1:, 1:], R[1:, 1:]))


def test_what_does_not_fit_is_refused(positive):
    A, B = positive(2, 4)
    for R in (torch.eye(3), torch.triu(torch.ones(4, 4))):
        with pytest.raises(InputError, match="R: expected a symmetric matrix of 4 functions"):
            blend(A, B, R)
    with pytest.raises(InputError, match="positive definite"):
        blend(A, -B, torch.eye(4))
