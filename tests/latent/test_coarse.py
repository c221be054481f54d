"""The coarse space of sparse networks, where everything is known: on maps that are perfectly consistent."""

import numpy as np
import pytest
import torch
from scipy.sparse import csgraph, csr_array

from lssd_learn.latent import coarse
from lssd_learn.latent.explicit import ExplicitForm
from lssd_learn.latent.graphs import topology

N, K = 24, 3


@pytest.fixture
def ring():
    """A ring of 24 shapes, each joined to the next four, whose maps C_ij = R_j R_iᵀ lose nothing; its R (24, 3, 3)."""
    R = torch.linalg.qr(torch.randn(N, K, K, dtype=torch.float64, generator=torch.Generator().manual_seed(0)))[0]
    edges = topology.tidy(np.array([(i, (i + step) % N) for i in range(N) for step in (1, 2, 3, 4)]))
    both = np.concatenate([edges, edges[:, ::-1]])
    return ExplicitForm(N, both, np.ones(len(both)), lambda i, targets: R[targets] @ R[i].T), R


def test_consistent_maps_make_the_form_a_graph_laplacian_in_frames(ring):
    form, _ = ring
    lowest = form._coarse.lowest(K + 2 * K)
    values = torch.einsum("nm,nm->m", lowest, form.apply(lowest))
    # A ring's slowest waves come in pairs, of 2 Σ_step 2 (1 − cos(2π step / N)) each way.
    slow = sum(4 * (1 - np.cos(2 * np.pi * step / N)) for step in (1, 2, 3, 4))
    expected = torch.tensor([0.0] * K + [slow] * 2 * K, dtype=torch.float64)
    torch.testing.assert_close(values, expected, rtol=0, atol=1e-9)
    torch.testing.assert_close(form.apply(lowest), lowest * values, rtol=0, atol=1e-9)


def test_the_coarse_inverse_undoes_the_form_on_slow_vectors(ring):
    form, _ = ring
    slow = form._coarse.lowest(3 * K)
    back = form._coarse.inverse(0.1)(form.apply(slow) + 0.1 * slow)
    torch.testing.assert_close(back, slow, rtol=0, atol=1e-9)


def test_the_frames_carry_the_functions_of_one_shape_to_all(ring):
    form, R = ring
    constant = form._coarse.lowest(K).view(N, K, K)
    torch.testing.assert_close(R.mT @ constant, (R[0].T @ constant[0]).expand(N, K, K), rtol=0, atol=1e-9)


def test_frames_learn_how_long_functions_are_on_each_shape(monkeypatch):
    """Where areas differ, maps C_ij = s_j / s_i carry R_i s_i to R_j s_j, and frames that only turn cost energy."""
    lengths = 1 + 0.2 * torch.randn(N, 1, 1, dtype=torch.float64, generator=torch.Generator().manual_seed(1))
    edges = topology.clique(N)  # no direction is slow: only the frames tell
    both = np.concatenate([edges, edges[:, ::-1]])
    identity = torch.eye(K, dtype=torch.float64)

    def energy():
        form = ExplicitForm(N, both, np.ones(len(both)), lambda i, targets: lengths[targets] / lengths[i] * identity)
        constant = form._coarse.lowest(K)
        return torch.einsum("nm,nm->m", constant, form.apply(constant)), form._coarse._values[:K]

    energies, foreseen = energy()
    torch.testing.assert_close(energies, foreseen)  # the constant mode's are exact
    assert energies.max() < 0.05 * N
    monkeypatch.setattr(coarse, "SMOOTHING", 0)
    assert energy()[0].min() > 20 * energies.max()


def test_a_clique_needs_the_constant_mode_only():
    everyone = topology.clique(6)
    both = np.concatenate([everyone, everyone[:, ::-1]])
    form = ExplicitForm(
        6, both, np.ones(len(both)), lambda i, targets: torch.eye(2).double().expand(len(targets), 2, 2)
    )
    assert form._coarse.lowest(100).shape == (12, 2)


@pytest.mark.parametrize("kind", ["chain", "cloud"])
def test_slow_modes_of_many_shapes_are_those_of_the_full_matrix(kind, monkeypatch):
    """Nearly, and orthonormal: along a chain, where they are very slow, and among points in space."""
    n = 700
    points = np.random.default_rng(0).normal(size=(n, 3))
    edges = topology.nearest(np.arange(float(n))[:, None] if kind == "chain" else points, 10)
    both = np.concatenate([edges, edges[:, ::-1]]).T
    laplacian = csr_array(csgraph.laplacian(csr_array((np.ones(both.shape[1]), tuple(both)), shape=(n, n))))
    exact_values, exact = (part.numpy() for part in coarse._slow_modes(laplacian, 8))
    monkeypatch.setattr(coarse, "DENSE", 100)
    values, found = (part.numpy() for part in coarse._slow_modes(laplacian, 8))
    np.testing.assert_allclose(found.T @ found, np.eye(8), atol=1e-9)
    # Of the same energies, to a thousandth of a degree, and of the same span.
    energy = [np.diag(V.T @ (laplacian @ V)) for V in (exact, found)]
    degree = laplacian.diagonal().mean()
    np.testing.assert_allclose(energy[1], energy[0], atol=1e-3 * degree)
    np.testing.assert_allclose(exact_values, energy[0], atol=1e-9)
    np.testing.assert_allclose(values, energy[1], atol=1e-6 * degree)
    assert np.linalg.svd(exact[:, :6].T @ found)[1].min() > 0.99


def rounds(n, monkeypatch):
    """How many products with W a network of n shapes takes, each joined to 20 nearest on a line, of uneven maps."""
    generator = torch.Generator().manual_seed(0)
    R = torch.linalg.qr(torch.randn(n, 6, 6, dtype=torch.float64, generator=generator))[0]
    lengths = 1 + 0.1 * torch.rand(n, 1, 1, dtype=torch.float64, generator=generator)
    cost = 10.0 ** torch.linspace(-4, -1, 6, dtype=torch.float64)  # later functions are mapped worse
    noise = torch.randn(n, 6, 6, dtype=torch.float64, generator=generator)

    def maps(i, targets):
        carried = R[targets] * (lengths[targets] / lengths[i]) @ R[i].T
        return carried + (R[targets] * cost) @ (noise[targets] + noise[i]) @ R[i].T

    edges = topology.nearest(np.sort(np.random.default_rng(0).random(n))[:, None], 20)
    both = np.concatenate([edges, edges[:, ::-1]])
    form = ExplicitForm(n, both, np.ones(len(both)), maps)
    apply, count = form.apply, []
    monkeypatch.setattr(form, "apply", lambda Y: count.append(Y.shape[1]) or apply(Y))
    form.lowest(6, 1e-6)
    return len(count)


def test_four_times_the_shapes_take_hardly_more_products(monkeypatch):
    few, many = (rounds(n, monkeypatch) for n in (300, 1200))
    assert many <= few + 8  # 25 more with no more than ten slow modes
