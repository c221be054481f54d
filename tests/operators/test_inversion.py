"""Shapes of operators by optimisation, against shapes that are known."""

import numpy as np
import pytest
import torch

from lssd_learn.differentiable import vertex_operators
from lssd_learn.errors import InputError
from lssd_learn.latent import LatentSpace, MapNetwork
from lssd_learn.latent.differences import stack_differences
from lssd_learn.operators import functions_of, shape_of_operators
from lssd_learn.operators.inversion import KINDS, _lowest
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
    found = shape_of_operators(wanted, start, faces, B, space.seen, prior=1e-4)
    assert found.losses[-1] < found.losses[0]
    before, after = (np.abs(distances(x) - distances(truth)).max() for x in (start, found.vertices))
    assert after < 0.1 * before
    with pytest.raises(InputError, match=r"^operators: expected \(3, 10, 10\), got \(2, 10, 10\)"):
        shape_of_operators(wanted[:2], start, faces, B, space.seen)


def test_a_larger_shape_is_first_scaled(small):
    meshes, space = small
    faces, B = meshes[0].faces, space.to_shape(torch.eye(space.keep).double(), 0)
    wanted = vertex_operators(torch.tensor(3 * meshes[0].vertices), torch.tensor(faces), B, space.seen)
    found = shape_of_operators(wanted, meshes[0].vertices, faces, B, space.seen)
    np.testing.assert_allclose(found.vertices, 3 * meshes[0].vertices, atol=1e-6)
    assert found.losses[0] < 1e-12


def test_functions_that_follow_the_shape_come_near(small):
    """Of another shape's own operators: those of where it has come to are what it is seen by."""
    meshes, space = small
    faces, wanted = meshes[0].faces, stack_differences(space, KINDS)
    follow = functions_of(space, faces, [2, 3, 4, 5])
    for kinds in (KINDS, KINDS[:2]):
        found = shape_of_operators(wanted[1, : len(kinds)], meshes[0].vertices, faces, follow, space.seen, kinds)
        after, before = (
            np.abs(distances(x) - distances(meshes[1].vertices)).mean() for x in (found.vertices, meshes[0].vertices)
        )
        assert after < 0.7 * before


def test_operators_of_a_few_functions_are_those_of_a_space_that_keeps_as_many(small):
    meshes, space = small
    found, seen = _lowest(stack_differences(space, KINDS)[0], space.seen, KINDS, 6)
    torch.testing.assert_close(found, stack_differences(space.with_keep(6), KINDS)[0], rtol=0, atol=1e-9)
    assert len(seen.spectrum) == 6
