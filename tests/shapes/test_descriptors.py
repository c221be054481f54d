"""Signatures of points: laws, a slow twin, and a sphere, all of whose points look the same."""

import numpy as np
import pytest

from lssd_learn.errors import InputError
from lssd_learn.shapes import Eigenbasis, Mesh, eigenbasis
from lssd_learn.shapes.descriptors import (
    at_unit_area,
    heat_kernel_signature,
    wave_bounds,
    wave_kernel_maps,
    wave_kernel_signature,
)


@pytest.fixture(scope="module")
def basis(small_mesh):
    return eigenbasis(small_mesh, 30)


def test_unit_area_is_what_the_scaled_shape_has(small_mesh, basis):
    scaled = eigenbasis(Mesh(small_mesh.vertices / np.sqrt(small_mesh.area), small_mesh.faces), 30)
    unit = at_unit_area(basis)
    assert unit.area == pytest.approx(1)
    np.testing.assert_allclose(unit.evals, scaled.evals, atol=1e-8)
    np.testing.assert_allclose(unit.evecs, scaled.evecs, atol=1e-7)


def heat_signature(basis, n):
    return heat_kernel_signature(basis, np.geomspace(0.01, 0.3, n))


@pytest.mark.parametrize("signature", [heat_signature, wave_kernel_signature])
def test_neither_size_nor_place_nor_order_nor_signs_matter(small_mesh, basis, signature):
    order = np.random.default_rng(0).permutation(642)
    turn = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0]
    other = eigenbasis(Mesh(7 * small_mesh.vertices[order] @ turn + 3, np.argsort(order)[small_mesh.faces]), 30)
    np.testing.assert_allclose(signature(other, 12), signature(basis, 12)[order], rtol=1e-6)


@pytest.mark.parametrize("signature", [heat_signature, wave_kernel_signature])
def test_their_mean_over_the_shape_is_one(basis, signature):
    mean = basis.mass @ signature(basis, 9) / basis.area
    np.testing.assert_allclose(mean, 1, rtol=1e-12)


@pytest.mark.parametrize("signature", [heat_signature, wave_kernel_signature])
def test_all_points_of_a_sphere_look_the_same(sphere, signature):
    """Complete levels: 1 + 3 + 5 + 7 + 9 functions."""
    np.testing.assert_allclose(signature(eigenbasis(sphere, 25), 10), 1, atol=0.05)


def test_wave_kernels_are_the_sums_they_claim_to_be(basis):
    unit, n, p = at_unit_area(basis), 5, 17
    low, high = np.log(unit.evals[1]), np.log(unit.evals[-1])
    step = (high - low) / (n + 28)  # n steps and two free ends of 2 σ = 14 steps each
    signature, maps = wave_kernel_signature(basis, n), wave_kernel_maps(basis, [p], n)
    for i in range(n):
        weights = np.exp(-((low + (14 + i) * step - np.log(unit.evals[1:])) ** 2) / (2 * (7 * step) ** 2))
        weights /= weights.sum()
        np.testing.assert_allclose(signature[:, i], (unit.evecs[:, 1:] ** 2 * weights).sum(axis=1))
        expected = sum(w * f[p] * f for w, f in zip(weights, unit.evecs[:, 1:].T, strict=True))
        np.testing.assert_allclose(unit.evecs @ maps[:, 0, i], expected, atol=1e-12)


def test_the_map_of_a_landmark_is_the_signature_at_it(basis):
    maps = wave_kernel_maps(basis, [3, 500], 8)
    values = np.einsum("mk,kmn->mn", at_unit_area(basis).evecs[[3, 500]], maps)
    np.testing.assert_allclose(values, wave_kernel_signature(basis, 8)[[3, 500]])
    assert wave_kernel_maps(basis, np.empty(0, int), 8).shape == (30, 0, 8)


def test_two_shapes_share_their_energies(basis, sphere):
    other = eigenbasis(sphere, 20)
    low, high = wave_bounds(basis, other)
    assert low == max(np.log(b.evals[1] * b.area) for b in (basis, other))
    assert high == min(np.log(b.evals[-1] * b.area) for b in (basis, other))
    far = wave_kernel_signature(basis, 4, (200.0, 200.5))  # no level anywhere near: the last one counts
    np.testing.assert_allclose(far, np.repeat(at_unit_area(basis).evecs[:, -1:] ** 2, 4, axis=1), rtol=1e-6)


def test_two_levels_are_enough(basis):
    assert np.isfinite(wave_kernel_signature(basis.truncate(2), 3)).all()
    with pytest.raises(InputError, match="signatures: expected 2 eigenfunctions or more, got 1"):
        wave_kernel_signature(basis.truncate(1), 3)


def test_errors(basis):
    with pytest.raises(InputError, match="n=0: expected a whole number, 1 or more"):
        wave_kernel_signature(basis, 0)
    with pytest.raises(InputError, match="landmarks: expected vertices, 0 to 641, got -1"):
        wave_kernel_maps(basis, [0, -1])
    with pytest.raises(InputError, match="expected shapes with overlapping spectra"):
        wave_bounds(basis.truncate(2), Eigenbasis(basis.evals * 100, basis.evecs, basis.mass))
