"""Differences from a base shape, against the products of maps built one by one."""

import numpy as np
import pytest
import torch

from lssd_learn.errors import InputError
from lssd_learn.latent import MapNetwork
from lssd_learn.latent.base_shape import BaseShapes
from lssd_learn.maps import from_correspondence
from lssd_learn.shapes import Mesh, eigenbasis


@pytest.fixture(scope="module")
def bases(many_bodies):
    """Twelve bodies of 615 vertices, 50 functions."""
    return [basis.truncate(50) for basis in many_bodies[:12]]


@pytest.fixture(scope="module")
def shapes(bases):
    return BaseShapes(MapNetwork.clique(bases), 20)


@pytest.mark.parametrize("base", [0, 7])
def test_differences_are_the_explicit_products(bases, shapes, base):
    area, conformal = shapes.differences(base)
    root = np.r_[0, bases[base].evals[1:20] ** -0.5]
    for j, basis in enumerate(bases):
        C = from_correspondence(bases[base], basis)[:, :20]
        np.testing.assert_allclose(area[j], C.T @ C, atol=2e-3)
        wanted = root[:, None] * (C.T @ (basis.evals[:, None] * C)) * root
        np.testing.assert_allclose(conformal[j], wanted, atol=5e-3)


def test_the_error_of_the_factored_maps_is_far_below_the_spread(bases, shapes):
    exact = torch.stack([torch.as_tensor(from_correspondence(bases[3], basis)[:, :20]) for basis in bases])
    wanted, area = exact.mT @ exact, shapes.differences(3)[0]
    assert (area - wanted).norm() < 5e-3 * (wanted - wanted.mean(0)).norm()


def test_the_base_does_not_differ_from_itself(shapes):
    area, conformal = shapes.differences(5)
    np.testing.assert_allclose(area[5], np.eye(20), atol=1e-3)
    np.testing.assert_allclose(conformal[5], np.diag(np.r_[0, np.ones(19)]), atol=5e-3)


def test_they_are_symmetric_and_the_constant_is_null_in_the_conformal_ones(shapes):
    for difference in shapes.differences(1):
        torch.testing.assert_close(difference, difference.mT)
    assert not shapes.differences(1)[1][:, 0].any()


def test_twice_as_large_is_four_times_the_area_and_the_same_angles(meshes):
    sphere = meshes[0]
    pair = [eigenbasis(shape, 161) for shape in (sphere, Mesh(2 * sphere.vertices, sphere.faces))]
    area, conformal = BaseShapes(MapNetwork.clique(pair), 10).differences(0)
    np.testing.assert_allclose(area[1], 4 * np.eye(10), atol=1e-8)
    np.testing.assert_allclose(conformal[1], np.diag(np.r_[0, np.ones(9)]), atol=1e-8)


def test_maps_of_ones_own_serve_as_well(bases, shapes):
    network = MapNetwork.clique(bases, lambda i, j: from_correspondence(bases[i], bases[j]))
    for given, factored in zip(BaseShapes(network, 20).differences(4), shapes.differences(4), strict=True):
        torch.testing.assert_close(given, factored, rtol=0, atol=5e-3)


def test_a_map_that_is_missing_is_an_error_and_that_to_itself_is_not_asked_for(bases):
    def star(i, j):
        assert i != j
        if 0 not in (i, j):
            raise InputError(f"no map from {i} to {j}")
        return from_correspondence(bases[i], bases[j])

    shapes = BaseShapes(MapNetwork.star(bases, maps=star), 20)
    assert shapes.differences(0)[0].shape == (12, 20, 20)
    with pytest.raises(InputError, match="no map from 1 to 2"):
        shapes.differences(1)


@pytest.mark.parametrize("keep", [0, 51])
def test_keep_has_bounds(bases, keep):
    with pytest.raises(InputError, match=f"keep={keep}: expected 1 to 50"):
        BaseShapes(MapNetwork.clique(bases), keep)
