"""Shapes of operators by optimisation, against shapes that are known."""

import numpy as np
import pytest
import torch

from lssd_learn.differentiable import vertex_operators
from lssd_learn.errors import InputError
from lssd_learn.latent import LatentSpace, MapNetwork
from lssd_learn.latent.differences import stack_differences
from lssd_learn.operators import functions_of, shape_of_operators
from lssd_learn.operators.inversion import KINDS
from lssd_learn.shapes import eigenbasis


@pytest.fixture(scope="module")
def small(deformed_spheres):
    """Six deformed spheres of 42 vertices and their latent space."""
    meshes = deformed_spheres(6, 1)
    return meshes, LatentSpace.fit(MapNetwork.clique([eigenbasis(mesh, 16) for mesh in meshes]), 14, 10)


def distances(x):
    return np.linalg.norm(x[:, None] - x, axis=2)


def test_a_smooth_displacement_comes_back(small):
    """Up to a rigid motion; bad input is refused."""
    meshes, space = small
    faces, B = meshes[0].faces, space.to_shape(torch.eye(space.keep).double(), 0)
    start = meshes[0].vertices
    truth = start + (B @ (0.1 * torch.randn(10, 3, generator=torch.Generator().manual_seed(0)).double())).numpy()
    wanted = vertex_operators(torch.tensor(truth), torch.tensor(faces), B, space.seen)
    found = shape_of_operators(wanted, start, faces, B, space.seen, rounds=4)
    assert found.losses[-1] < 1e-4 * found.losses[0]
    before, after = (np.abs(distances(x) - distances(truth)).max() for x in (start, found.vertices))
    assert after < 0.1 * before
    with pytest.raises(InputError, match=r"^operators: expected \(3, 10, 10\), got \(2, 10, 10\)"):
        shape_of_operators(wanted[:2], start, faces, B, space.seen)


def test_functions_that_follow_the_shape_come_nearer(small):
    """Of another shape's own operators, with the functions of the start and with those of where it has come to."""
    meshes, space = small
    faces, wanted = meshes[0].faces, stack_differences(space, KINDS)[1]
    own = space.to_shape(torch.eye(space.keep).double(), 0)
    follow = functions_of(space, faces, [2, 3, 4, 5])
    errors = []
    for functions in (own, follow):
        found = shape_of_operators(wanted, meshes[0].vertices, faces, functions, space.seen)
        errors.append(np.abs(distances(found.vertices) - distances(meshes[1].vertices)).mean())
    start = np.abs(distances(meshes[0].vertices) - distances(meshes[1].vertices)).mean()
    assert errors[1] < errors[0] < start
