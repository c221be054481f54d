import numpy as np
import pytest
import torch


@pytest.fixture(scope="session")
def positive():
    """A function (n, m, seed) → n symmetric positive definite matrices, eigenvalues within a factor e² of 1."""

    def make(n, m, seed=0, spread=2.0):
        rng = np.random.default_rng(seed)
        V = np.linalg.qr(rng.normal(size=(n, m, m)))[0]
        return torch.from_numpy((V * np.exp(rng.uniform(-spread, spread, (n, 1, m)))) @ V.swapaxes(1, 2))

    return make


@pytest.fixture(scope="session")
def conformal(positive):
    """The same, with a first function that is null, as the constant of conformal operators in their symmetric form."""

    def make(n, m, seed=0):
        D = torch.zeros(n, m, m, dtype=torch.float64)
        D[:, 1:, 1:] = positive(n, m - 1, seed)
        return D

    return make


@pytest.fixture(scope="session")
def functions():
    """A function (m, r, seed) → F (m, r) orthonormal."""
    return lambda m, r, seed=0: torch.from_numpy(
        np.linalg.qr(np.random.default_rng(seed).normal(size=(m, m)))[0][:, :r]
    )


@pytest.fixture(scope="session")
def untruncated():
    """A function (n, m, seed) → n area operators of full information on m vertices, and the F of a random region."""

    def make(n, m, seed=0):
        rng = np.random.default_rng(seed)
        masses = rng.uniform(0.5, 2, (n, m))
        average = masses.mean(0)
        Phi = np.linalg.qr(rng.normal(size=(m, m)))[0] / np.sqrt(average)[:, None]
        region = rng.random(m) < 0.5
        F = (np.sqrt(average)[:, None] * Phi)[region].T
        return torch.from_numpy(Phi.T @ (masses[:, :, None] * Phi)), torch.from_numpy(F), masses, Phi, region

    return make
