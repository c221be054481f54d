"""The block eigensolver against the dense one."""

import logging

import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st

from lssd_learn.errors import InputError
from lssd_learn.latent import MapNetwork, consistent_basis
from lssd_learn.latent.eigen import lowest_eigenpairs


def problem(evals, block, seed=0):
    """A dense symmetric matrix of these eigenvalues, a start block and a rough inverse."""
    generator = torch.Generator().manual_seed(seed)
    N = len(evals)
    U = torch.linalg.qr(torch.randn(N, N, dtype=torch.float64, generator=generator))[0]
    W = (U * evals) @ U.T
    start = torch.randn(N, block, dtype=torch.float64, generator=generator)
    diagonal = W.diagonal()[:, None]
    return W, start, lambda R: R / diagonal


def check(evals, wanted, block, seed=0, tolerance=1e-9):
    W, start, rough = problem(evals, block, seed)
    scale = float(evals[-1])
    values, X = lowest_eigenpairs(lambda Y: W @ Y, start, wanted, rough, scale, tolerance, most=2000)
    assert (values.shape, X.shape) == ((block,), (len(evals), block))
    torch.testing.assert_close(values[:wanted], evals[:wanted], rtol=0, atol=1e-9 * scale)
    torch.testing.assert_close(X.T @ X, torch.eye(block, dtype=X.dtype), rtol=0, atol=1e-10)
    residual = (W @ X - X * values)[:, :wanted].norm(dim=0)
    assert float(residual.max()) <= 1.1 * tolerance * scale
    assert (values.diff() >= -1e-12 * scale).all()


@given(seed=st.integers(0, 10**6), N=st.integers(60, 150), wanted=st.integers(1, 8), guards=st.integers(1, 6))
@settings(max_examples=20, deadline=None)
def test_random_positive_definite_matrices(seed, N, wanted, guards):
    G = torch.randn(N, 2 * N, dtype=torch.float64, generator=torch.Generator().manual_seed(seed))
    check(torch.linalg.eigvalsh(G @ G.T / N), wanted, wanted + guards, seed)


@pytest.mark.parametrize("wanted", [3, 6, 8])
@pytest.mark.parametrize("width", [0.0, 1e-9, 1e-5])
def test_clusters_at_and_below_the_cut_off(wanted, width):
    levels = torch.tensor([0.0, 1.0, 1.1, 5.0], dtype=torch.float64).repeat_interleave(torch.tensor([6, 5, 20, 169]))
    check((levels + width * torch.linspace(0, 1, 200, dtype=torch.float64)).sort().values, wanted, 12)


def test_a_start_that_is_the_answer_stays():
    W, start, rough = problem(torch.arange(50.0, dtype=torch.float64), 5)
    exact = torch.linalg.eigh(W)[1][:, :5]
    values, X = lowest_eigenpairs(lambda Y: W @ Y, exact, 5, rough, 50.0, 1e-10)
    torch.testing.assert_close(values, torch.arange(5.0, dtype=torch.float64), rtol=0, atol=1e-9)
    torch.testing.assert_close((X * exact).sum(0).abs(), torch.ones(5, dtype=X.dtype))


def test_no_convergence_is_an_error_that_says_how_far_it_came():
    W, start, rough = problem(torch.linspace(0, 1, 300, dtype=torch.float64), 4)
    with pytest.raises(RuntimeError, match=r"did not converge in 2 rounds: residual .*e-0\d, asked 1.0e-12"):
        lowest_eigenpairs(lambda Y: W @ Y, start, 4, rough, 1.0, 1e-12, most=2)


def test_eigenvalues_that_still_fall_are_not_taken_for_settled():
    W, start, rough = problem(torch.linspace(0, 1, 300, dtype=torch.float64), 4)
    with pytest.raises(RuntimeError, match="did not converge in 12 rounds"):
        lowest_eigenpairs(lambda Y: W @ Y, start, 4, rough, 1.0, 1e-12, most=12)


def test_a_cluster_that_is_cut_is_told_and_any_of_its_vectors_serves(caplog):
    """Thirty nearly equal eigenvalues, ten of them wanted: they do not converge one by one."""
    evals = torch.cat([1 + 1e-6 * torch.linspace(0, 1, 30), torch.linspace(5, 9, 170)]).double()
    W, start, rough = problem(evals, 12)
    with caplog.at_level(logging.WARNING):
        values, X = lowest_eigenpairs(lambda Y: W @ Y, start, 10, rough, 9.0, 1e-12, most=60)
    assert "of 10 consistent functions lie in a cluster that is cut: not unique" in caplog.text
    torch.testing.assert_close(values[:10], torch.ones(10, dtype=X.dtype), rtol=0, atol=1e-5)
    torch.testing.assert_close(X.T @ X, torch.eye(12, dtype=X.dtype), rtol=0, atol=1e-10)
    assert float((W @ X - X * values)[:, :10].norm(dim=0).max()) < 1e-4


def test_noise_is_not_taken_for_an_answer():
    generator = torch.Generator().manual_seed(0)
    _, start, rough = problem(torch.linspace(0, 1, 100, dtype=torch.float64), 4)
    with pytest.raises(RuntimeError, match="did not converge"):
        lowest_eigenpairs(
            lambda Y: torch.randn(Y.shape, dtype=Y.dtype, generator=generator), start, 4, rough, 1.0, 1e-6, most=30
        )


@pytest.mark.parametrize("size", [1, 20, 30])
def test_the_consistent_basis_is_normalised_and_ordered(truncated, size):
    form = MapNetwork.clique(truncated(6, 30)).form()
    consistent = consistent_basis(form, size)
    assert consistent.Y.shape == (6, 30, size)
    gram = (consistent.Y.mT @ consistent.Y).sum(0)
    torch.testing.assert_close(gram, 6 * torch.eye(size, dtype=gram.dtype), rtol=0, atol=1e-9)
    X = consistent.Y.flatten(0, 1) / 6**0.5
    torch.testing.assert_close(form.apply(X), X * consistent.energy, rtol=0, atol=1e-9)
    torch.testing.assert_close(consistent.energy, torch.linalg.eigvalsh(form.dense())[:size], rtol=0, atol=1e-9)


def test_a_size_there_is_not_is_refused(truncated):
    form = MapNetwork.clique(truncated(3, 10)).form()
    for size in (0, 11):
        with pytest.raises(InputError, match=f"size={size}: expected 1 to 10, the number of eigenfunctions a shape"):
            consistent_basis(form, size)
