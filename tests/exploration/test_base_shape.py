"""Base-shape differences and the energy of adjoint maps, beside the latent ones."""

import numpy as np
import pytest
import torch

from lssd_learn.errors import InputError
from lssd_learn.exploration import adjoint_energy, base_shape_differences, pair_energies
from lssd_learn.latent import LatentSpace, MapNetwork


def close(actual, expected, atol=1e-4):
    torch.testing.assert_close(actual, expected, rtol=0, atol=atol)


def test_of_a_clique_they_are_those_of_the_direct_maps(truncated):
    network = MapNetwork.clique(truncated(5, 20))
    area, conformal = base_shape_differences(network, 2)
    assert area.shape == conformal.shape == (5, 20, 20)
    for j in (0, 4):
        C, scale = network.map(2, j), np.r_[0, network.evals[2, 1:] ** -0.5]
        np.testing.assert_allclose(area[j], C.T @ C, atol=1e-5)
        expected = scale[:, None] * (C.T @ np.diag(network.evals[j]) @ C) * scale
        np.testing.assert_allclose(conformal[j], expected, atol=1e-4)
    close(area[2], torch.eye(20, dtype=torch.float64), atol=1e-5)
    close(base_shape_differences(network, 2, keep=7)[0], area[:, :7, :7])


@pytest.mark.parametrize("kind", ["chain", "star", "spanning_tree"])
def test_of_a_sparse_network_maps_are_composed_along_its_edges(truncated, kind):
    bases = truncated(5, 20)
    network = getattr(MapNetwork, kind)(bases)
    edges = {frozenset(edge) for edge in network.edges.tolist()}

    def only_edges(i, j):
        assert frozenset((i, j)) in edges
        return MapNetwork.clique(bases).map(i, j)

    area, _ = base_shape_differences(MapNetwork.from_edges(bases, network.edges, only_edges), 1)
    if kind == "chain":
        C = only_edges(3, 4) @ only_edges(2, 3) @ only_edges(1, 2)
        np.testing.assert_allclose(area[4], C.T @ C, atol=1e-10)
    close(base_shape_differences(network, 1)[0], area)


def test_with_nothing_truncated_neither_base_nor_topology_matters(untruncated_bases):
    """D_bj = Y_b D_b⁻¹ D_j Y_b⁻¹ whatever the network."""
    bases = untruncated_bases(5, 8)
    latent = LatentSpace.fit(MapNetwork.clique(bases), 8, 8)
    operators, _ = latent.differences()
    for kind in ("clique", "chain"):
        area, _ = base_shape_differences(getattr(MapNetwork, kind)(bases), 3)
        Y = latent.basis(3)
        close(area, Y @ torch.linalg.solve(operators[3], operators) @ torch.linalg.inv(Y))


@pytest.mark.parametrize("signs", [False, True])
def test_with_nothing_truncated_both_energies_have_the_same_eigenvectors(untruncated_bases, signs):
    """The paper's appendix: they commute, of the whole collection and of two groups, and neither repeats a value."""
    bases, groups = untruncated_bases(6, 9), list("aaabbb")
    network = MapNetwork.clique(bases)
    latent = LatentSpace.fit(network, 9, 9)
    E = pair_energies(latent.differences()[0], groups)
    weights = np.array([[-1.0 if signs and a == b else 1.0 for a in groups] for b in groups])
    ours, theirs = E.across + (-E.within if signs else E.within), adjoint_energy(network, latent.Y, weights)
    close(ours @ theirs, theirs @ ours, atol=1e-8 * float((ours @ theirs).norm()))
    evals, V = torch.linalg.eigh(ours)
    assert float(evals.diff().min()) > 1e-6 * float(evals.abs().max())
    diagonal = V.T @ theirs @ V
    close(diagonal, torch.diag(diagonal.diagonal()), atol=1e-6 * float(theirs.norm()))
    # Each of them is the indicator of one vertex.
    values = latent.to_shape(V, 0).abs()
    assert (values.max(0).values / values.sum(0) > 1 - 1e-6).all()


def test_with_nothing_truncated_the_adjoint_energy_is_that_of_the_masses(untruncated_bases):
    """Σ Φ₀ᵀ (M_i − M_j) M_j⁻¹ (M_i − M_j) Φ₀."""
    bases = untruncated_bases(3, 6)
    network = MapNetwork.chain(bases)
    latent = LatentSpace.fit(network, 6, 6)
    Phi = latent.to_shape(np.eye(6), 0).numpy()
    M = np.stack([basis.mass for basis in bases])
    pairs = [(0, 1), (1, 0), (1, 2), (2, 1)]
    diagonal = sum((M[i] - M[j]) ** 2 / M[j] for i, j in pairs)
    np.testing.assert_allclose(adjoint_energy(network, latent.Y), Phi.T @ (diagonal[:, None] * Phi), atol=1e-8)


def test_on_bodies_both_energies_light_up_the_same_functions(truncated):
    """Truncated, they agree nearly: the first five functions of each span four common dimensions of 20."""
    network = MapNetwork.clique(truncated(8, 40))
    latent = LatentSpace.fit(network, 32, 20)
    E = pair_energies(latent.differences()[0], "aaaabbbb")
    ours = torch.linalg.eigh(E.across + E.within)[1][:, -5:]
    theirs = torch.linalg.eigh(adjoint_energy(network, latent.Y))[1][:, -5:]
    assert float((ours.T @ theirs).square().sum()) > 4


def test_borders(truncated):
    network = MapNetwork.chain(truncated(3, 10))
    with pytest.raises(InputError, match="base=3: expected a whole number, 0 to 2"):
        base_shape_differences(network, 3)
    with pytest.raises(InputError, match="keep=11: expected 1 to 10"):
        base_shape_differences(network, 0, 11)
    with pytest.raises(InputError, match=r"weights: expected \(3, 3\), got \(2, 2\)"):
        adjoint_energy(network, torch.zeros(3, 10, 5), np.ones((2, 2)))
