import numpy as np
import pytest

from lssd_learn import eigensolver
from lssd_learn.eigensolver import _smallest, smallest_eigenpairs


def operator(evals, shift, seed=0):
    """A dense symmetric matrix of these eigenvalues, and its shifted inverse as a function."""
    U = np.linalg.qr(np.random.default_rng(seed).standard_normal((len(evals), len(evals))))[0]
    return U * evals @ U.T, lambda X: U @ ((U.T @ X) / (evals - shift)[:, None])


@pytest.mark.parametrize("shift", [-0.1, 7.3, 40.7])
@pytest.mark.parametrize("n", [40, 500])
def test_known_spectrum(n, shift):
    evals = np.arange(n) * 1.0
    A, solve = operator(evals, shift)
    values, X = smallest_eigenpairs(solve, n, 20, shift)
    np.testing.assert_allclose(values, evals[:20], atol=1e-9)
    np.testing.assert_allclose(X.T @ X, np.eye(20), atol=1e-12)
    np.testing.assert_allclose(A @ X, X * values, atol=1e-5)


@pytest.mark.parametrize("shift", [-0.1, 2.5])
def test_multiple_eigenvalues_come_with_all_their_copies(shift):
    evals = np.sort(np.repeat(np.arange(100.0), 6))
    _, solve = operator(evals, shift)
    values, X = smallest_eigenpairs(solve, 600, 33, shift)
    np.testing.assert_allclose(values, evals[:33], atol=1e-9)
    np.testing.assert_allclose(X.T @ X, np.eye(33), atol=1e-12)


def test_an_exhausted_krylov_space_goes_on():
    """Three different eigenvalues only: the third block has nothing new."""
    evals = np.repeat([0.0, 1.0, 2.0], [10, 100, 300])
    _, solve = operator(evals, -0.1)
    values, X = smallest_eigenpairs(solve, 410, 15, -0.1)
    np.testing.assert_allclose(values, evals[:15], atol=1e-9)
    np.testing.assert_allclose(X.T @ X, np.eye(15), atol=1e-10)


def test_the_seed_decides_the_bits():
    _, solve = operator(np.arange(400.0), -0.1)
    first, again, other = (smallest_eigenpairs(solve, 400, 10, -0.1, seed=seed)[1] for seed in (0, 0, 1))
    assert np.array_equal(first, again)
    assert not np.array_equal(first, other)


def test_what_does_not_converge_is_an_error():
    noise = np.random.default_rng(0)
    with pytest.raises(ArithmeticError, match="5 eigenpairs did not converge in a basis of"):
        smallest_eigenpairs(lambda X: noise.standard_normal(X.shape), 2000, 5, -1.0)


def test_spurious_values_are_not_taken_for_eigenvalues():
    """Between −1/shift and 0 no θ of an operator without negative eigenvalues can lie: λ = shift + 1/θ would be < 0."""
    shift = 2.0
    theta = np.array([-0.5, -0.4, -1e-3, 0.25, 1.0, -4.0])  # λ = 0, −.5, −998, 6, 3, 1.75
    wanted, values = _smallest(theta, shift, 6)
    np.testing.assert_allclose(values, [0, 1.75, 3, 6])
    np.testing.assert_array_equal(wanted, [0, 5, 4, 3])
    wanted, values = _smallest(theta, -0.5, 6)  # a shift below zero: what is negative is no eigenvalue at all
    np.testing.assert_allclose(values, [0.5, 3.5])


def test_residuals_are_small_beside_the_eigenvalues():
    """Those of A, ten thousand times its largest wanted eigenvalue, not of its inverse, which hardly sees that."""
    evals = np.concatenate([np.arange(300.0), np.geomspace(300, 1e6, 3000)])
    values, X = smallest_eigenpairs(lambda X: X / (evals - 40.5)[:, None], len(evals), 80, 40.5)
    residuals = np.linalg.norm(evals[:, None] * X - X * values, axis=0)
    assert (residuals <= 4e-7 * np.maximum(values, 1e-2 * values[-1])).all()


def test_a_block_between_that_goes_astray_is_noticed(monkeypatch):
    """A shift that all but hits an eigenvalue: what rounding brings of its vector grows a millionfold a block."""
    evals = np.arange(500.0)
    A, solve = operator(evals, 30 + 1e-6)
    groups, lanczos = [], eigensolver._lanczos

    def counted(*args):
        groups.append(args[-1])
        return lanczos(*args)

    monkeypatch.setattr(eigensolver, "_lanczos", counted)
    values, X = smallest_eigenpairs(solve, 500, 60, 30 + 1e-6)
    assert groups == [2, 1]
    np.testing.assert_allclose(values, evals[:60], atol=1e-6)
    np.testing.assert_allclose(X.T @ X, np.eye(60), atol=1e-11)


def test_blocks_in_groups_are_as_orthogonal_as_one_by_one(monkeypatch):
    evals = np.arange(900.0) ** 2
    _, solve = operator(evals, 1000.5)
    together, X = smallest_eigenpairs(solve, 900, 60, 1000.5)
    monkeypatch.setattr(eigensolver, "GROUP", 1)
    apart, _ = smallest_eigenpairs(solve, 900, 60, 1000.5)
    np.testing.assert_allclose(together[1:], apart[1:], rtol=1e-10)
    np.testing.assert_allclose(X.T @ X, np.eye(60), atol=1e-13)
