import numpy as np
import pytest
import scipy.linalg
import torch

from lssd_learn.latent import LatentSpace, MapNetwork
from lssd_learn.shapes import Eigenbasis, laplacian


@pytest.fixture(scope="session")
def network():
    """A function (topology, bases) → the network, of four neighbours where it takes a number."""

    def make(kind, bases, **kwargs):
        return getattr(MapNetwork, kind)(bases, **({"neighbours": 4} if kind == "nearest" else {}), **kwargs)

    return make


@pytest.fixture(scope="session")
def gauge():
    """A function (D, E) → signs s, one a latent function, that bring operators E (n, m, m) nearest to D: s E s."""

    def signs(D, E):
        # s_a s_b is the sign of Σ D_ab E_ab; a Perron vector puts all these pairs together.
        pairs = (torch.as_tensor(D) * torch.as_tensor(E)).sum(0)
        s = torch.linalg.eigh(pairs + pairs.T)[1][:, -1].sign()
        return s[:, None] * s

    return signs


@pytest.fixture(scope="session")
def same_operators(gauge):
    """A function that asserts two latent spaces equal up to the signs of their functions."""

    def check(a: LatentSpace, b: LatentSpace, order=None, atol=1e-8):
        area, conformal = a.differences()
        area_b, conformal_b = b.differences()
        if order is not None:
            area, conformal = area[order], conformal[order]
        s = gauge(torch.cat([area, conformal]), torch.cat([area_b, conformal_b]))
        torch.testing.assert_close(b.spectrum, a.spectrum, rtol=atol, atol=atol * float(a.spectrum[-1]))
        torch.testing.assert_close(s * area_b, area, rtol=0, atol=atol)
        torch.testing.assert_close(s * conformal_b, conformal, rtol=0, atol=10 * atol)

    return check


@pytest.fixture(scope="session")
def fit():
    """A function (bases, size, keep) → the latent space of their clique."""
    return lambda bases, size=None, keep=None, **kwargs: LatentSpace.fit(MapNetwork.clique(bases), size, keep, **kwargs)


@pytest.fixture(scope="session")
def average():
    """A function (meshes, k) → the average shape's first k frequencies and functions, and every L_i and M_i, dense."""

    def make(meshes, k):
        Ls, Ms = zip(*(laplacian(mesh) for mesh in meshes), strict=True)
        Ls = np.stack([L.toarray() for L in Ls])
        evals, Phi = scipy.linalg.eigh(Ls.mean(0), np.diag(np.mean(Ms, 0)), subset_by_index=[0, k - 1])
        return evals, Phi, Ls, np.stack(Ms)

    return make


@pytest.fixture(scope="session")
def full_basis():
    """A function mesh → its eigenbasis with as many functions as vertices."""

    def make(mesh):
        L, M = laplacian(mesh)
        evals, evecs = scipy.linalg.eigh(L.toarray(), np.diag(M))
        return Eigenbasis(evals, evecs, M, mesh.connectivity)

    return make


@pytest.fixture(scope="session")
def spectra():
    """A function (n, k) → n eigenbases that are spectra only, for networks whose maps are given."""

    def make(n, k, seed=0):
        evals = np.sort(np.random.default_rng(seed).uniform(1, 50, (n, k)), axis=1)
        evals[:, 0] = 0
        return [Eigenbasis(row, np.eye(k), np.ones(k)) for row in evals]

    return make
