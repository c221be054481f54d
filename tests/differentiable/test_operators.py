"""Operators as functions of vertices: against those of the latent space, by gradcheck, and turned round."""

from dataclasses import replace

import numpy as np
import pytest
import torch

from lssd_learn.differentiable.operators import KINDS
from lssd_learn.errors import InputError
from lssd_learn.latent import LatentSpace, MapNetwork
from lssd_learn.latent.differences import DIFFERENCES, Difference, register, stack_differences
from lssd_learn.operators import shape_of_operators, vertex_operators
from lssd_learn.shapes import eigenbasis


@pytest.fixture(scope="module")
def small(deformed_spheres):
    """Four deformed spheres of 42 vertices and their latent space."""
    meshes = deformed_spheres(4, 1)
    return meshes, LatentSpace.fit(MapNetwork.clique([eigenbasis(mesh, 16) for mesh in meshes]), 14, 10)


def functions(space, i):
    return space.to_shape(torch.eye(space.keep).double(), i)


def test_at_the_vertices_of_a_shape_they_are_its_operators(small):
    meshes, space = small
    expected = stack_differences(space, KINDS)
    for i, mesh in enumerate(meshes):
        found = vertex_operators(torch.tensor(mesh.vertices), torch.tensor(mesh.faces), functions(space, i), space.seen)
        torch.testing.assert_close(found, expected[i], rtol=0, atol=1e-8)


@pytest.mark.parametrize("shape", ["deformed", "sphere"])
def test_gradients(small, deformed_spheres, shape):
    """Also on the sphere itself, whose eigenvalues come in clusters."""
    meshes, space = small
    mesh, few = meshes[0], space.with_keep(5)
    X = mesh.vertices / np.linalg.norm(mesh.vertices, axis=1, keepdims=True) if shape == "sphere" else mesh.vertices
    X, faces, B = torch.tensor(X).requires_grad_(), torch.tensor(mesh.faces), functions(few, 0)
    assert torch.autograd.gradcheck(lambda X: vertex_operators(X, faces, B, few.seen), X, atol=1e-6, rtol=1e-6)


def test_an_operator_is_turned_round_by_descent(small):
    """A displacement of the smooth kind comes back from another start, up to a rigid motion; bad input is refused."""
    meshes, space = small
    faces, B = meshes[0].faces, functions(space, 0)
    start = meshes[0].vertices
    truth = start + (B @ (0.1 * torch.randn(10, 3, generator=torch.Generator().manual_seed(0)).double())).numpy()
    wanted = vertex_operators(torch.tensor(truth), torch.tensor(faces), B, space.seen)
    found = shape_of_operators(wanted, start, faces, B, space.seen, rounds=6, stay=0)
    assert found.losses[-1] < 1e-4 * found.losses[0]

    def distances(x):
        return np.linalg.norm(x[:, None] - x, axis=2)

    before, after = (np.abs(distances(x) - distances(truth)).max() for x in (start, found.vertices))
    assert after < 0.1 * before
    with pytest.raises(InputError, match=r"^operators: expected \(3, 10, 10\), got \(2, 10, 10\)"):
        shape_of_operators(wanted[:2], start, faces, B, space.seen)


def test_what_is_not_differentiable_says_so(small, monkeypatch):
    meshes, space = small
    monkeypatch.setattr("lssd_learn.latent.differences.DIFFERENCES", dict(DIFFERENCES))
    register(Difference("theirs", lambda seen: replace(seen).Y))
    with pytest.raises(InputError, match="^theirs: expected some of area, conformal, extrinsic; others are not"):
        vertex_operators(
            torch.tensor(meshes[0].vertices), torch.tensor(meshes[0].faces), functions(space, 0), space.seen, ["theirs"]
        )
