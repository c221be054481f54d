"""42 vertices, 42 functions: nothing is truncated, and nothing may be lost."""

import numpy as np
import pytest
import torch

from lssd_learn.latent import LatentSpace, MapNetwork, pseudo_inverse


@pytest.fixture(scope="module")
def meshes(deformed_spheres):
    return deformed_spheres(7, 1)


@pytest.fixture(scope="module")
def latent(meshes, full_basis):
    return LatentSpace.fit(MapNetwork.clique([full_basis(mesh) for mesh in meshes]), 42, 42)


def test_operators_give_back_masses_and_stiffness(meshes, latent, average):
    """M_i = Φ₀⁻ᵀ D_i^A Φ₀⁻¹ and L_i = Φ₀⁻ᵀ Λ₀ D_i^C Φ₀⁻¹, in the eigenbasis Φ₀ of the average shape."""
    evals, Phi, Ls, Ms = average(meshes, 42)
    np.testing.assert_allclose(latent.spectrum.numpy(), evals, rtol=1e-9, atol=1e-9)
    # Only the signs are left open, and they are read off the latent functions on any shape.
    seen = latent.to_shape(np.eye(42), 2).numpy()
    Phi = Phi * np.sign(Phi.T @ (Ms.mean(0)[:, None] * seen)).diagonal()
    np.testing.assert_allclose(seen, Phi, atol=1e-7)
    inverse = np.linalg.inv(Phi)
    area, conformal = (D.numpy() for D in latent.differences())
    np.testing.assert_allclose(inverse.T @ area @ inverse, [np.diag(M) for M in Ms], atol=1e-8)
    np.testing.assert_allclose(inverse.T @ (evals[:, None] * conformal) @ inverse, Ls, atol=1e-7)


def test_conformal_operators_are_functorial_up_to_constants(latent):
    """D_ij = Λ_i⁺ C_ijᵀ Λ_j C_ij = Y_i (D_i^C)⁻¹ D_j^C Y_i⁻¹ on all functions but the constant."""
    _, conformal = latent.differences()
    for i, j in ((0, 1), (5, 2)):
        Y, C = latent.basis(i), latent.map(i, j)
        inverse = pseudo_inverse(latent.evals[i])
        direct = inverse[:, None] * (C.T @ (latent.evals[j][:, None] * C))
        through = torch.zeros_like(direct)
        through[1:, 1:] = torch.linalg.solve(conformal[i, 1:, 1:], conformal[j, 1:, 1:])
        through = Y @ through @ torch.linalg.inv(Y)
        torch.testing.assert_close(through[1:], direct[1:], rtol=0, atol=1e-7 * float(direct.norm()))


def test_maps_are_the_correspondence_itself(latent):
    for i, j in ((0, 1), (6, 3)):
        C = latent.map(i, j).numpy()
        carried = latent.bases[j].evecs @ C @ np.linalg.inv(latent.bases[i].evecs)
        np.testing.assert_allclose(carried, np.eye(42), atol=1e-7)


@pytest.mark.parametrize("kind", ["chain", "spanning_tree", "star", "nearest"])
def test_the_topology_does_not_matter(latent, kind, network, same_operators):
    same_operators(latent, LatentSpace.fit(network(kind, latent.bases), 42, 42), atol=1e-7)
