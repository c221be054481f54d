"""Maps, latent bases and operators: those of the latent space, and their derivatives against differences."""

import numpy as np
import pytest
import torch
import trimesh
from torch.autograd import gradcheck

from lssd_learn.differentiable import (
    eigenbasis,
    functional_map,
    latent_basis,
    latent_operators,
    pushed_functions,
    pushed_operators,
)
from lssd_learn.errors import InputError
from lssd_learn.latent import LatentSpace, MapNetwork
from lssd_learn.latent.differences import stack_differences
from lssd_learn.maps import from_correspondence
from lssd_learn.shapes import eigenbasis as eigenbasis_of_arrays

KINDS = ("area", "conformal", "extrinsic")


@pytest.fixture(scope="module")
def four(deformed_spheres):
    """Vertices of four deformed spheres (4, 42, 3), their faces, eigenbases and latent space."""
    meshes = deformed_spheres(4, 1)
    bases = [eigenbasis_of_arrays(mesh, 16) for mesh in meshes]
    space = LatentSpace.fit(MapNetwork.clique(bases), 14, 9)
    return torch.tensor(np.stack([m.vertices for m in meshes])), torch.tensor(meshes[0].faces), bases, space


def test_all_is_that_of_the_latent_space(four):
    X, faces, bases, space = four
    found = eigenbasis(X, faces, 16)
    order = np.roll(np.arange(42), 1)
    for match in (None, order):
        C = functional_map(found[0], bases[1], match)
        np.testing.assert_allclose(C, from_correspondence(bases[0], bases[1], match), atol=1e-7)
    latent = latent_basis(found, 14, 9)
    torch.testing.assert_close(latent.spectrum[1:], space.spectrum[1:], rtol=1e-7, atol=1e-7)
    torch.testing.assert_close(latent.Y, space.Y, rtol=0, atol=1e-6)
    torch.testing.assert_close(latent_operators(latent, found), stack_differences(space, KINDS), rtol=0, atol=1e-6)


def test_edges_and_maps_are_those_of_the_network(four):
    X, faces, bases, _ = four
    edges = [(0, 1), (1, 2), (2, 3)]
    maps = lambda i, j: torch.from_numpy(from_correspondence(bases[i], bases[j]))  # noqa: E731
    space = LatentSpace.fit(MapNetwork.from_edges(bases, edges, maps=maps), 10, 6)
    found = eigenbasis(X, faces, 16)
    for given in (None, maps):
        torch.testing.assert_close(latent_basis(found, 10, 6, edges, given).Y, space.Y, rtol=0, atol=1e-6)


def test_a_new_shape_in_a_space_that_stays(four, deformed_spheres):
    _, faces, _, space = four
    mesh = deformed_spheres(5, 1)[4]
    old = eigenbasis_of_arrays(mesh, 16)
    maps = {i: (from_correspondence(b, old), from_correspondence(old, b)) for i, b in enumerate(space.bases[:2])}
    pushed = space.push(old, maps)
    new = eigenbasis(torch.tensor(mesh.vertices), faces, 16)
    Y = pushed_functions(space, new, [0, 1])
    torch.testing.assert_close(Y, pushed.basis, rtol=0, atol=1e-6)
    expected = stack_differences(pushed.seen, KINDS)[0]
    torch.testing.assert_close(pushed_operators(space, new, Y), expected, rtol=0, atol=1e-6)


@pytest.mark.parametrize("shape", ["deformed", "sphere"])
def test_gradients_of_operators_in_a_space_that_stays(four, shape):
    X, faces, _, space = four
    x = torch.tensor(trimesh.creation.icosphere(1).vertices) if shape == "sphere" else X[3]

    def seen(x):
        basis = eigenbasis(x, faces, 9 if shape == "sphere" else 16)
        few = space if shape == "deformed" else _cut(space, 9)
        return pushed_operators(few, basis, pushed_functions(few, basis, [0, 2]))[:, ::3, ::4]

    assert gradcheck(seen, x.clone().requires_grad_(), atol=1e-6, rtol=1e-6, fast_mode=True)


def _cut(space, k):
    return LatentSpace.fit(MapNetwork.clique([basis.truncate(k) for basis in space.bases]), 7, 6)


@pytest.mark.parametrize("shape", ["deformed", "sphere"])
def test_gradients_through_the_latent_basis(four, shape):
    """Of what no choice of the latent functions changes: how far operators lie apart, their eigenvalues' sums.

    Spheres that differ by their size alone have a latent space whose frequencies come in clusters.
    """
    X, faces, _, _ = four
    if shape == "sphere":
        X = torch.tensor(trimesh.creation.icosphere(1).vertices) * torch.tensor([1, 1.1, 1.3]).double()[:, None, None]

    def seen(X):
        bases = eigenbasis(X, faces, 9)
        D = latent_operators(latent_basis(bases, 9, 9), bases)
        return (D[0] - D[1]).square().sum((1, 2)), D.square().sum((0, 2, 3)), D.diagonal(dim1=-2, dim2=-1).sum(-1)

    assert gradcheck(seen, X.clone().requires_grad_(), atol=1e-6, rtol=1e-6, fast_mode=True)


def test_bad_input(four):
    X, faces, _, space = four
    bases = eigenbasis(X, faces, 9)
    with pytest.raises(InputError, match="^size=10, keep=2: expected 1 ≤ keep ≤ size ≤ 9"):
        latent_basis(bases, 10, 2)
    with pytest.raises(InputError, match="^vertices: expected one for each of the 42 of the target, got 3"):
        functional_map(bases[0], bases[1], np.arange(3))
    with pytest.raises(InputError, match="expected some of area, conformal, extrinsic"):
        latent_operators(latent_basis(bases, 9, 5), bases, ["theirs"])
