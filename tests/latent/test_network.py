"""The network: its energy in both forms, its maps and what it refuses."""

import tempfile

import numpy as np
import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st

from lssd_learn.errors import InputError
from lssd_learn.latent import (
    ExplicitForm,
    FactorisedForm,
    LatentSpace,
    MapNetwork,
    compressed_factors,
    exact_factors,
)
from lssd_learn.latent import factorised as factorised_module
from lssd_learn.latent import factors as factors_module
from lssd_learn.latent import network as network_module
from lssd_learn.maps import from_correspondence
from lssd_learn.shapes import Eigenbasis

WEIGHTS = np.array([0.5, 2.0, 1.0, 0.1, 3.0, 1.5])


def energy(y, edges, weights, maps):
    """Σ w_ij ‖C_ij y_i − y_j‖², edge after edge."""
    return sum(w * float(((maps(i, j) @ y[i] - y[j]) ** 2).sum()) for (i, j), w in zip(edges, weights, strict=True))


@given(seed=st.integers(0, 10**6), n=st.integers(2, 6), k=st.integers(1, 5))
@settings(max_examples=40, deadline=None)
def test_the_explicit_form_is_the_energy_of_the_network(seed, n, k):
    rng = np.random.default_rng(seed)
    C = rng.normal(size=(n, n, k, k))
    one_way = [(i, j) for i in range(n) for j in range(i) if i == j + 1 or rng.random() < 0.5]
    edges = rng.permutation(np.array(one_way + [e[::-1] for e in one_way]))
    weights = rng.random(len(edges)) + 0.1
    form = ExplicitForm(n, edges, weights, lambda i, targets: torch.from_numpy(C[i, targets]))
    y = rng.normal(size=(n, k))
    W = form.dense()
    expected = energy(y, edges.tolist(), weights, lambda i, j: C[i, j])
    assert float(y.ravel() @ W.numpy() @ y.ravel()) == pytest.approx(expected)
    torch.testing.assert_close(W, W.T, rtol=0, atol=1e-12)
    Y = torch.from_numpy(rng.normal(size=(n * k, 3)))
    torch.testing.assert_close(form.apply(Y), W @ Y)
    blocks = torch.stack([W[i * k : (i + 1) * k, i * k : (i + 1) * k] for i in range(n)])
    torch.testing.assert_close(form.diagonal, blocks)


@pytest.mark.parametrize("weights", [None, WEIGHTS])
def test_the_factorised_form_is_the_explicit_one(truncated, weights):
    bases = truncated(6, 40)
    explicit = MapNetwork.clique(bases, weights=weights).form("explicit")
    u = None if weights is None else torch.from_numpy(weights)
    factorised = FactorisedForm(exact_factors(bases), u)
    Y = torch.randn(240, 7, dtype=torch.float64, generator=torch.Generator().manual_seed(0))
    expected = explicit.dense() @ Y
    torch.testing.assert_close(factorised.dense() @ Y, expected, rtol=0, atol=1e-8)
    torch.testing.assert_close(explicit.apply(Y), expected, rtol=0, atol=1e-8)


@pytest.mark.parametrize("tolerance", [1e-5, 1e-10])
@pytest.mark.parametrize("size", [1, 24, 30])
@pytest.mark.parametrize("weights", [None, np.tile(WEIGHTS, 2)])
def test_the_lowest_functions_of_the_factorised_form_are_those_of_the_dense_one(
    truncated, weights, size, tolerance, monkeypatch
):
    """By moments where they are good enough, by iteration from there where not; in chunks that do not divide n."""
    monkeypatch.setattr(factorised_module, "CHUNK", 5)
    form = FactorisedForm(compressed_factors(truncated(12, 30)), None if weights is None else torch.from_numpy(weights))
    W = form.dense()
    energy, X = form.lowest(size, tolerance)
    norm = float(torch.linalg.matrix_norm(W, 2))
    torch.testing.assert_close(energy, torch.linalg.eigvalsh(W)[:size], rtol=0, atol=tolerance * norm)
    torch.testing.assert_close(X.T @ X, torch.eye(size).double(), rtol=0, atol=1e-10)
    assert float((W @ X - X * energy).norm(dim=0).max()) <= 1.1 * tolerance * norm


@pytest.mark.parametrize("weights", [None, WEIGHTS])
def test_weighted_forms_are_the_weighted_energy(truncated, weights):
    bases = truncated(6, 10)
    u = np.ones(6) if weights is None else weights
    edges = [(i, j) for i in range(6) for j in range(6) if i != j]
    y = np.random.default_rng(0).normal(size=(6, 10))
    expected = energy(y, edges, [u[i] * u[j] for i, j in edges], lambda i, j: from_correspondence(bases[i], bases[j]))
    for method in ("explicit", "factorised"):
        W = MapNetwork.clique(bases, weights=weights).form(method, rank=60).dense().numpy()
        assert y.ravel() @ W @ y.ravel() == pytest.approx(expected, rel=1e-4 if method == "factorised" else 1e-10)


def test_the_preconditioner_of_a_sparse_graph_inverts_the_whole_form(truncated):
    form = MapNetwork.chain(truncated(9, 12)).form()
    Y = form.dense() @ torch.randn(108, 2, dtype=torch.float64, generator=torch.Generator().manual_seed(0))
    back = form.dense() @ form.precondition(Y)
    torch.testing.assert_close(back, Y, rtol=0, atol=1e-4)


@pytest.mark.parametrize("bases_of", [np.float64, np.float32])
@pytest.mark.parametrize("k", [30, 80])
def test_compressed_correspondences_give_eigenvalues_of_the_operators_to_four_digits(truncated, k, bases_of):
    bases = [Eigenbasis(b.evals, b.evecs.astype(bases_of), b.mass, b.connectivity) for b in truncated(20, k)]
    network = MapNetwork.clique(bases)
    size, keep = k * 4 // 5, k // 2
    exact, compressed = (
        LatentSpace.fit(network, size, keep, method=method).differences() for method in ("explicit", "factorised")
    )
    for a, b in ((exact[0], compressed[0]), (exact[1], compressed[1])):
        error = (torch.linalg.eigvals(a).real.sort(1).values - torch.linalg.eigvals(b).real.sort(1).values).abs()
        assert float(error.max()) < 1e-4


def test_compression_loses_less_with_more_functions(truncated):
    bases = truncated(12, 20)
    lost = [compressed_factors(bases, rank).lost for rank in (20, 60, 120)]
    assert lost[0] > 2 * lost[1] > 4 * lost[2]
    full = compressed_factors(bases, 240)
    assert full.lost < 1e-3
    C = torch.from_numpy(from_correspondence(bases[2], bases[7]))
    torch.testing.assert_close(full.maps(2, [7])[0], C, rtol=0, atol=1e-5)
    torch.testing.assert_close(exact_factors(bases).maps(2, [7, 3])[0], C, rtol=0, atol=1e-12)


def test_the_seed_of_the_sketch_decides_the_bits(truncated):
    first, again, other = (compressed_factors(truncated(6, 20), 60, seed).A for seed in (0, 0, 1))
    assert torch.equal(first, again)
    assert not torch.equal(first, other)


def test_factors_on_the_disk_are_those_in_memory(truncated, monkeypatch, tmp_path):
    network = MapNetwork.clique(truncated(11, 30))
    held, space = compressed_factors(network.bases), LatentSpace.fit(network, 24, 24, method="factorised")
    monkeypatch.setattr(factors_module, "HELD", 0)
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    spilled = compressed_factors(network.bases)
    for name in ("A", "B"):
        inside, outside = getattr(held, name), getattr(spilled, name)
        assert outside.shape == inside.shape
        assert torch.equal(outside[:], inside)
        assert torch.equal(outside[7:20], inside[7:])
        assert torch.equal(outside[[4, 2]], inside[[4, 2]])
        assert torch.equal(outside[3], inside[3])
    assert torch.equal(spilled.maps(2, [7, 3]), held.maps(2, [7, 3]))
    assert torch.equal(LatentSpace.fit(network, 24, 24, method="factorised").Y, space.Y)
    assert list(tmp_path.iterdir()) == []  # nobody sees them, and a kill leaves none


@pytest.mark.parametrize("kind", ["nearest", "star"])
def test_a_large_sparse_network_takes_its_maps_from_the_factors(truncated, kind, network, monkeypatch):
    net = network(kind, truncated(12, 30))
    exact = net.form()
    monkeypatch.setattr(network_module, "EXACT_PRODUCTS", 0)
    factorised = net.form()
    assert isinstance(factorised, ExplicitForm)
    torch.testing.assert_close(factorised.dense(), exact.dense(), rtol=0, atol=2e-3)
    area, other = (
        LatentSpace.fit(net, 24, 12, method=method).differences()[0] for method in ("explicit", "factorised")
    )
    assert float((torch.linalg.eigvalsh(area) - torch.linalg.eigvalsh(other)).abs().max()) < 2e-4


def test_the_form_is_chosen_by_size_and_maps(truncated, monkeypatch):
    bases = truncated(5, 10)
    assert isinstance(MapNetwork.clique(bases).form(), ExplicitForm)
    assert isinstance(MapNetwork.clique(bases).form("factorised"), FactorisedForm)
    monkeypatch.setattr(network_module, "EXACT_PRODUCTS", 0)
    assert isinstance(MapNetwork.clique(bases).form(), FactorisedForm)
    given = MapNetwork.clique(bases, maps=lambda i, j: np.eye(10))
    assert isinstance(given.form(), ExplicitForm)
    with pytest.raises(InputError, match="only for shapes in vertex correspondence"):
        given.form("factorised")
    with pytest.raises(InputError, match="method='fast': expected auto, explicit or factorised"):
        given.form("fast")


def test_maps_are_vertex_identity_unless_given(truncated):
    bases = truncated(4, 10)
    np.testing.assert_array_equal(MapNetwork.chain(bases).map(2, 0), from_correspondence(bases[2], bases[0]))
    told = MapNetwork.chain(bases, maps=lambda i, j: np.full((5, 5), 10.0 * i + j))
    assert (told.map(2, 0) == 20).all()


def test_maps_may_be_arrays_or_tensors_of_either_precision(spectra):
    R = np.linalg.qr(np.random.default_rng(0).normal(size=(4, 6, 6)))[0].astype(np.float32)
    areas = []
    for wrap in (np.asarray, torch.tensor):
        net = MapNetwork.chain(spectra(4, 6), maps=lambda i, j, wrap=wrap: wrap(R[j] @ R[i].T))
        areas.append(LatentSpace.fit(net, 6, 6).differences()[0])
    torch.testing.assert_close(areas[0], areas[1], rtol=0, atol=0)
    assert areas[0].dtype == torch.float64


def test_edges_of_ones_own(truncated):
    bases = truncated(4, 10)
    net = MapNetwork.from_edges(bases, [[2, 0], [1, 2], [3, 1]], weights=[1, 2, 3])
    y = np.random.default_rng(0).normal(size=(4, 10))
    both = [(2, 0), (0, 2), (1, 2), (2, 1), (3, 1), (1, 3)]
    expected = energy(y, both, [1, 1, 2, 2, 3, 3], lambda i, j: from_correspondence(bases[i], bases[j]))
    assert y.ravel() @ net.form().dense().numpy() @ y.ravel() == pytest.approx(expected)


def test_a_disconnected_network_is_refused_and_its_components_named(truncated):
    with pytest.raises(
        InputError, match=r"edges: expected a connected network, got 3 components: \{0, 1, 4\}; \{2, 3\}; \{5\}"
    ):
        MapNetwork.from_edges(truncated(6, 5), [[0, 1], [4, 1], [3, 2]])
    with pytest.raises(InputError, match="got 6 components"):
        MapNetwork.from_edges(truncated(6, 5), [])


@pytest.mark.parametrize(
    ("edges", "message"),
    [
        ([[0, 1], [1, 3]], "edges: expected shape numbers 0 to 2, got 0 to 3"),
        ([[0, 1], [-1, 1]], "edges: expected shape numbers 0 to 2, got -1 to 1"),
        ([[0, 1], [1, 2], [2, 2]], "a loop or a repeated pair"),
        ([[0, 1], [1, 2], [1, 0]], "a loop or a repeated pair"),
        ([[0, 1], [2]], r"edges: expected pairs of shape numbers, .* got \[\[0, 1\], \[2\]\]"),
        ([[0, "b"]], "edges: expected pairs of shape numbers"),
        ([[0, None]], "edges: expected pairs of shape numbers"),
        ([[0.5, 1]], "edges: expected pairs of shape numbers"),
        ([0, 1], "edges: expected pairs of shape numbers"),
        ("all", "edges: expected pairs of shape numbers, .* got all"),
    ],
)
def test_impossible_edges_are_refused(truncated, edges, message):
    with pytest.raises(InputError, match=message):
        MapNetwork.from_edges(truncated(3, 5), edges)


@pytest.mark.parametrize("weights", [[1, 2], [1, 2, -1], [1, 2, 0], [1, 2, np.nan], [1, 2, 3, 4], ["a", 1, 2]])
def test_weights_that_are_not_one_positive_number_each_are_refused(truncated, weights):
    with pytest.raises(InputError, match="weights: expected 3 positive numbers"):
        MapNetwork.clique(truncated(3, 5), weights=weights)
    with pytest.raises(InputError, match="weights: expected 3 positive numbers"):
        MapNetwork.from_edges(truncated(4, 5), [[0, 1], [1, 2], [2, 3]], weights=weights)


def test_vertex_identity_needs_one_connectivity(truncated):
    bases = truncated(3, 5)
    other = Eigenbasis(bases[1].evals, bases[1].evecs, bases[1].mass, "other")
    cloud = Eigenbasis(bases[1].evals, bases[1].evecs, bases[1].mass, None)
    with pytest.raises(InputError, match="shape 2 differs from shape 0"):
        MapNetwork.clique([bases[0], bases[1], other])
    with pytest.raises(InputError, match="point clouds"):
        MapNetwork.clique([cloud, cloud])
    with pytest.raises(InputError, match="shape 1 differs from shape 0"):
        MapNetwork.chain([bases[0], cloud])
    MapNetwork.chain([cloud, cloud], maps=lambda i, j: np.eye(5))
    with pytest.raises(InputError, match="a network needs at least 2 shapes, got 1"):
        MapNetwork.clique(bases[:1])
