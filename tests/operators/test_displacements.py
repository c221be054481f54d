"""Derivatives along fields, against differences and against autograd."""

import pytest
import torch

from lssd_learn.differentiable import vertex_operators
from lssd_learn.latent import LatentSpace, MapNetwork
from lssd_learn.operators.displacements import operator_derivatives
from lssd_learn.operators.vectors import entries
from lssd_learn.shapes import eigenbasis


@pytest.mark.parametrize("kinds", [("area", "conformal", "extrinsic"), ("extrinsic", "area"), ("conformal",)])
def test_they_are_those_of_the_operators(deformed_spheres, kinds, monkeypatch):
    """Way 3 j + t is field j along axis t; rows come in pieces."""
    monkeypatch.setattr("lssd_learn.operators.displacements.ROWS", 50)
    meshes = deformed_spheres(4, 1)
    space = LatentSpace.fit(MapNetwork.clique([eigenbasis(mesh, 16) for mesh in meshes]), 14, 6)
    X, faces = torch.tensor(meshes[0].vertices), torch.tensor(meshes[0].faces)
    B = space.to_shape(torch.eye(6).double(), 0)
    fields = torch.randn(len(X), 4, generator=torch.Generator().manual_seed(0)).double()

    def operators(c):
        return entries(vertex_operators(X + fields @ c.view(4, 3), faces, B, space.seen, kinds)).flatten()

    expected = torch.autograd.functional.jacobian(operators, torch.zeros(12).double()).mT
    found = operator_derivatives(X, faces, B, space.seen, fields, kinds)
    torch.testing.assert_close(found, expected, rtol=0, atol=1e-10 * float(expected.abs().max()))
