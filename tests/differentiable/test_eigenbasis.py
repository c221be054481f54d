"""Derivatives of the eigenbasis against differences, where eigenvalues are simple and where they are not."""

import math

import numpy as np
import pytest
import torch
import trimesh
from torch.autograd import gradcheck

from lssd_learn.differentiable import eigenbasis
from lssd_learn.errors import InputError
from lssd_learn.shapes import Mesh
from lssd_learn.shapes import eigenbasis as eigenbasis_of_arrays


@pytest.fixture(scope="module")
def bodies(deformed_spheres):
    """Name → vertices, and their faces; eigenvalues come in clusters on a sphere, in pairs on one that is stretched."""
    mesh = deformed_spheres(1, 1)[0]
    sphere = np.array(trimesh.creation.icosphere(1).vertices)
    stretched = sphere + 0.4 * sphere @ np.outer(sphere[0], sphere[0])  # along a fivefold axis
    found = {"deformed": mesh.vertices, "sphere": sphere, "stretched": stretched}
    return {name: torch.tensor(x) for name, x in found.items()}, torch.tensor(mesh.faces)


@pytest.mark.parametrize("name", ["deformed", "sphere", "stretched"])
def test_it_is_the_eigenbasis_of_arrays(bodies, deformed_spheres, name):
    X, faces = bodies[0][name], bodies[1]
    basis, expected = eigenbasis(X, faces, 9), eigenbasis_of_arrays(Mesh(X.numpy(), faces.numpy()), 9)
    np.testing.assert_allclose(basis.evals, expected.evals, atol=1e-9)
    np.testing.assert_allclose(basis.mass, expected.mass)
    if name == "deformed":
        np.testing.assert_allclose(basis.evecs, expected.evecs, atol=1e-7)
    batch = eigenbasis(torch.stack([X, 2 * X]), faces, 9)
    torch.testing.assert_close(batch[0].form, basis.form)
    torch.testing.assert_close(4 * batch[1].form, basis.form, rtol=1e-8, atol=1e-9)
    assert len(batch) == 2


def test_eigenvalues_are_equal_where_they_should_be(bodies):
    for name, counts in {"deformed": [1] * 9, "sphere": [1, 3, 5], "stretched": [1, 1, 2, 1, 2, 2]}.items():
        evals = eigenbasis(bodies[0][name], bodies[1], 9).evals
        starts = (evals.diff(prepend=-evals.new_ones(1)) > 1e-6).nonzero().flatten().tolist()
        assert sorted(np.diff([*starts, 9])) == sorted(counts), name


@pytest.mark.parametrize("clusters", [1e-6, math.inf])
@pytest.mark.parametrize("name", ["deformed", "sphere", "stretched"])
def test_what_does_not_depend_on_the_frame_has_its_gradient(bodies, name, clusters):
    """The projection on the span, energies, heat: no rotation within a cluster changes them."""
    X, faces = bodies[0][name], bodies[1]
    probes = torch.randn(len(X), 2, generator=torch.Generator().manual_seed(0)).double()

    def seen(X):
        basis = eigenbasis(X, faces, 9, clusters)
        carried = basis.evecs.mT @ probes
        heat = torch.linalg.matrix_exp(-basis.form / 4)
        return carried.mT @ carried, carried.mT @ basis.form @ carried, carried.mT @ heat @ carried, heat.trace()

    assert gradcheck(seen, X.clone().requires_grad_(), atol=1e-6, rtol=1e-6, fast_mode=True)


def test_simple_functions_have_gradients_of_their_own(bodies):
    X, faces = bodies[0]["deformed"], bodies[1]

    def seen(X):
        basis = eigenbasis(X, faces, 9)
        return basis.evals[1:], basis.evecs[::14]

    assert gradcheck(seen, X.clone().requires_grad_(), atol=1e-6, rtol=1e-6)


def test_a_cluster_of_one_subspace_has_the_gradients_of_each(bodies):
    """What all frames agree on does not depend on how the clusters are told."""
    X, faces = bodies[0]["deformed"], bodies[1]
    grads = []
    for clusters in (1e-6, 0.3, math.inf):
        x = X.clone().requires_grad_()
        basis = eigenbasis(x, faces, 9, clusters)
        (basis.evecs @ basis.form @ basis.evecs.mT).pow(2).sum().backward()
        grads.append(x.grad)
    torch.testing.assert_close(grads[0], grads[1], rtol=1e-7, atol=1e-7)
    torch.testing.assert_close(grads[0], grads[2], rtol=1e-7, atol=1e-7)


def test_above_the_dense_solver_too(deformed_spheres):
    mesh = deformed_spheres(1, 3)[0]
    X, faces = torch.tensor(mesh.vertices), torch.tensor(mesh.faces)
    way = torch.randn(X.shape, generator=torch.Generator().manual_seed(0)).double()

    def heat(t):
        basis = eigenbasis(X + t * way, faces, 30)
        return torch.linalg.matrix_exp(-basis.form / 10).trace() + (basis.evecs[:9] @ basis.evecs[:9].mT).sum()

    assert gradcheck(heat, torch.zeros((), dtype=torch.float64, requires_grad=True), eps=1e-5, atol=1e-6, rtol=1e-6)


def test_what_is_not_differentiable_says_so(bodies):
    """A number of functions that cuts a cluster, a second derivative, clouds."""
    X, faces = bodies[0]["sphere"].clone().requires_grad_(), bodies[1]
    with pytest.raises(InputError, match=r"^k=3: no derivative, eigenvalues 3 and 4 are equal; expected a number"):
        eigenbasis(X, faces, 3).evals.sum().backward()
    with pytest.raises(InputError, match=r"^eigenbasis: first derivatives only; expected .* without create_graph=True"):
        torch.autograd.grad(eigenbasis(X, faces, 9).evals.sum(), X, create_graph=True)
    for wrong in (X.detach().numpy(), X.detach()[:, :2], faces):
        with pytest.raises(InputError, match="^vertices: expected a tensor of floating point numbers"):
            eigenbasis(wrong, faces, 9)
    with pytest.raises(InputError, match="^k: expected 1 to 41"):
        eigenbasis(X, faces, 42)


def test_float32_comes_back_as_it_came(bodies):
    X = bodies[0]["deformed"].float().requires_grad_()
    basis = eigenbasis(X, bodies[1], 9)
    assert basis.evecs.dtype == basis.mass.dtype == torch.float32
    basis.evals.sum().backward()
    assert X.grad.dtype == torch.float32
