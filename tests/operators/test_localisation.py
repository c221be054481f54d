"""One shape here, another there: exact where nothing is truncated, positive definite always."""

import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st

from lssd_learn.errors import InputError
from lssd_learn.operators import localise, null_functions

SIZES = {"m": st.integers(1, 7), "r": st.integers(0, 7), "seed": st.integers(0, 10**6)}


def close(actual, expected, atol=1e-9):
    torch.testing.assert_close(actual, expected.expand_as(actual), rtol=0, atol=atol)


def norm(D):
    return float(torch.linalg.matrix_norm(D))


@given(**SIZES)
@settings(max_examples=30, deadline=None)
def test_it_acts_like_B_on_the_region_and_like_A_elsewhere(positive, functions, m, r, seed):
    A, B = positive(4, m, seed).split(2)
    F = functions(m, m, seed)
    F, G = F[:, :r], F[:, r:]
    close(localise(A, B, F) @ F, B @ F)
    close(localise(A, B, F) @ G, A @ G)
    symmetric = localise(A, B, F, symmetric=True)
    close(F.T @ symmetric @ F, F.T @ B @ F)
    close(G.T @ symmetric @ G, G.T @ A @ G)
    close(localise(B, A, G, symmetric=True), symmetric)


@given(**SIZES)
@settings(max_examples=50, deadline=None)
def test_the_symmetric_form_is_positive_definite(positive, functions, m, r, seed):
    """Also of operators so different that the symmetric part of the plain form is not."""
    A, B = positive(10, m, seed, spread=4.0).split(5)
    D = localise(A, B, functions(m, min(m, r), seed), symmetric=True)
    close(D, D.mT)
    assert (torch.linalg.eigvalsh(D) > 0).all()


def test_the_symmetric_part_alone_would_not_be(positive, functions):
    A, B = positive(40, 5, 0, spread=4.0).split(20)
    plain = localise(A, B, functions(5, 2))
    assert float(torch.linalg.eigvalsh(plain + plain.mT).min()) < 0


@pytest.mark.parametrize("symmetric", [False, True])
def test_equal_shapes_no_region_and_the_whole(positive, functions, symmetric):
    A, B = positive(2, 5)
    close(localise(A, A, functions(5, 2), symmetric), A)
    close(localise(A, B, functions(5, 0), symmetric), A)
    close(localise(A, B, functions(5, 5), symmetric), B)


@given(seed=st.integers(0, 10**6))
@settings(max_examples=20, deadline=None)
def test_with_nothing_truncated_it_is_the_operator_of_the_mixed_shape(untruncated, seed):
    (A, B), F, masses, Phi, region = untruncated(2, 6, seed)
    mixed = masses[0].copy()
    mixed[region] = masses[1][region]
    exact = torch.from_numpy(Phi.T @ (mixed[:, None] * Phi))
    close(localise(A, B, F), exact)
    close(localise(A, B, F, symmetric=True), exact)


def test_near_the_identity_it_is_the_symmetric_part(positive, functions):
    """The error falls with the square of the deviation."""
    X, F = positive(2, 6) - torch.eye(6), functions(6, 3)
    errors = []
    for epsilon in (1e-2, 1e-3):
        A, B = torch.eye(6) + epsilon * X
        plain = localise(A, B, F)
        errors.append(norm(localise(A, B, F, symmetric=True) - (plain + plain.mT) / 2) / epsilon)
    assert errors[0] < 0.2
    assert errors[1] < 0.11 * errors[0]


@given(m=st.integers(2, 7), r=st.integers(0, 7), seed=st.integers(0, 10**6))
@settings(max_examples=30, deadline=None)
def test_the_null_function_stays_null_in_the_symmetric_form(conformal, functions, m, r, seed):
    A, B = conformal(2, m, seed)
    F = functions(m, m, seed)
    D = localise(A, B, F[:, :r], symmetric=True)
    assert null_functions(D).tolist() == [True] + (m - 1) * [False]
    assert float(D[0].abs().max()) == float(D[:, 0].abs().max()) == 0
    assert float(torch.linalg.eigvalsh(D[1:, 1:]).min()) > 0
    close(localise(B, A, F[:, r:], symmetric=True), D)
    close(localise(A, A, F[:, :r], symmetric=True), A)


def test_one_shape_against_many(positive, functions):
    A, B = positive(1, 4)[0], positive(3, 4, 1)
    for symmetric in (False, True):
        many = localise(A, B, functions(4, 2), symmetric)
        assert many.shape == (3, 4, 4)
        close(many[2], localise(A, B[2], functions(4, 2), symmetric))


def test_the_symmetric_form_refuses_what_has_no_root(positive, functions):
    A, B = positive(2, 4)
    with pytest.raises(InputError, match="D_B: expected positive definite operators"):
        localise(A, B - 10 * torch.eye(4), functions(4, 2), symmetric=True)
    with pytest.raises(
        InputError, match="D_A: expected symmetric operators .of conformal ones take the symmetric form"
    ):
        localise(A + torch.eye(4).roll(1, 0), B, functions(4, 2), symmetric=True)
