"""Projection against its formula, and the energy against the lemma."""

import numpy as np
import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st

from lssd_learn.errors import InputError
from lssd_learn.operators import delta_energy, localise, project

SIZES = {"m": st.integers(1, 6), "r": st.integers(0, 6), "seed": st.integers(0, 10**6)}


def operators(n, m, seed):
    """Symmetric or not."""
    return torch.from_numpy(np.random.default_rng(seed).normal(size=(n, m, m)))


@given(**SIZES)
@settings(max_examples=30, deadline=None)
def test_it_keeps_the_span_of_F_and_acts_like_D_off_it(functions, m, r, seed):
    D, F = operators(3, m, seed), functions(m, m, seed)
    F, G = F[:, :r], F[:, r:]
    P = project(D, F)
    torch.testing.assert_close(P @ F, F.expand(3, -1, -1))
    torch.testing.assert_close(P @ G, D @ G)
    torch.testing.assert_close(P, localise(D, torch.eye(m, dtype=torch.float64), F))


@given(**SIZES)
@settings(max_examples=30, deadline=None)
def test_delta_energy_is_what_projection_takes_from_the_distance(functions, m, r, seed):
    """The paper's Lemma, of operators that need not be symmetric."""
    D, E, F = operators(3, m, seed), operators(3, m, seed + 1), functions(m, min(r, m), seed)
    delta = delta_energy(D, E, F)
    assert (delta >= 0).all()
    before, after = (
        torch.linalg.matrix_norm(X).square() for X in (D - E, project(D, F) - project(E, F))
    )  # fmt: skip
    torch.testing.assert_close(delta, before - after, rtol=1e-9, atol=1e-9)
    squared = (D - E).mT @ (D - E)
    torch.testing.assert_close(delta, torch.einsum("ar,nab,br->n", F, squared, F), rtol=1e-9, atol=1e-9)


def test_all_functions_suppressed_leave_the_identity_and_none_the_operator(functions):
    D = operators(2, 4, 0)
    torch.testing.assert_close(project(D, functions(4, 4)), torch.eye(4, dtype=torch.float64).expand(2, -1, -1))
    torch.testing.assert_close(project(D, functions(4, 0)), D)
    assert float(delta_energy(D[0], D[1], functions(4, 4))) == pytest.approx(float((D[0] - D[1]).square().sum()))


def test_one_function_arrays_and_single_precision_are_taken():
    D = operators(2, 3, 0)
    alpha = np.array([0.6, 0.0, 0.8])
    torch.testing.assert_close(project(D.numpy(), alpha), project(D, alpha[:, None]))
    assert project(D.float(), torch.tensor(alpha)).dtype == torch.float64
    assert delta_energy(D[0], D, alpha).shape == (2,)


@pytest.mark.parametrize(
    ("D", "F", "message"),
    [
        (np.eye(3), 2 * np.eye(3), "F: expected orthonormal functions"),
        (np.eye(3), np.eye(2), r"F: expected functions \(3, r\) .* got \(2, 2\)"),
        (np.ones((3, 2)), np.eye(2), r"D: expected operators \(…, m, m\), got \(3, 2\)"),
        (np.full((2, 2), np.nan), np.eye(2), "D: expected finite numbers"),
    ],
)
def test_what_does_not_fit_is_refused(D, F, message):
    with pytest.raises(InputError, match=message):
        project(D, F)


def test_operators_of_two_sizes_are_refused():
    with pytest.raises(InputError, match="D_j: expected operators of 3 functions as the others, got 2"):
        delta_energy(np.eye(3), np.eye(2), np.eye(3))
