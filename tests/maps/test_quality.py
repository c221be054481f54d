"""Scores of maps whose errors are known."""

import numpy as np
import pytest

from lssd_learn.maps import (
    area_under_curve,
    coverage,
    cycle_error,
    euclidean_errors,
    flipped,
    from_correspondence,
    geodesic_errors,
    round_trip_errors,
    turned_over,
    unreached,
)
from lssd_learn.shapes import Mesh


def test_the_true_map_has_no_error(twins):
    for errors in (geodesic_errors, euclidean_errors):
        assert not errors(twins.source_shape, twins.true, twins.true).any()
    assert flipped(twins.side, twins.true, twins.true) == 0
    assert coverage(twins.source.mass, twins.true) == pytest.approx(1)
    assert not round_trip_errors(twins.source_shape, twins.true, np.argsort(twins.true)).any()


def test_errors_are_distances_over_the_root_of_the_area(twins):
    mesh, rng = twins.source_shape, np.random.default_rng(0)
    found, true = rng.integers(0, 615, (2, 40))
    straight, along = euclidean_errors(mesh, found, true), geodesic_errors(mesh, found, true)
    expected = np.linalg.norm(mesh.vertices[found] - mesh.vertices[true], axis=1) / mesh.area**0.5
    np.testing.assert_allclose(straight, expected)
    assert (along >= straight - 1e-12).all()
    bigger = Mesh(10 * mesh.vertices, mesh.faces)
    np.testing.assert_allclose(geodesic_errors(bigger, found, true), along)


def test_a_mirrored_map_is_flipped():
    side = np.array([-1, -0.5, -0.01, 0.02, 0.5, 1])
    identity = np.arange(6)
    assert flipped(side, identity[::-1], identity) == 1
    assert flipped(side, np.array([0, 1, 5, 0, 4, 0]), identity) == 0.25  # the two in the middle do not count
    assert flipped(side, identity[:2], np.array([2, 3])) == 0


def test_coverage_and_round_trip_see_a_fold(twins):
    everything_to_one = np.full(615, 7)
    assert coverage(twins.source.mass, everything_to_one) == pytest.approx(twins.source.mass[7] / twins.source.area)
    errors = round_trip_errors(twins.source_shape, everything_to_one, np.argsort(twins.true))
    assert errors[7] == 0
    assert errors.mean() > 0.5


def test_cycles_of_consistent_maps_close(twins):
    there = from_correspondence(twins.source, twins.target, twins.true)
    back = from_correspondence(twins.target, twins.source, np.argsort(twins.true))
    assert cycle_error(there, back) < 1e-9
    assert cycle_error(there, np.eye(50), back) < 1e-9
    mirror = np.diag(np.where(np.arange(50) % 2, -1.0, 1.0))
    assert cycle_error(there, mirror, back) == pytest.approx(np.sqrt(2), rel=0.1)
    assert cycle_error(there[:20], back[:, :20]) == pytest.approx(np.sqrt(30 / 50), rel=0.01)  # truncation alone


def test_the_area_under_the_curve_is_that_of_its_steps():
    errors = np.random.default_rng(0).exponential(0.1, 400)
    at = np.linspace(0, 0.25, 20001)
    curve = (errors[None, :] <= at[:, None]).mean(axis=1)
    assert area_under_curve(errors) == pytest.approx(np.trapezoid(curve, at) / 0.25, abs=1e-4)
    assert area_under_curve(np.zeros(3)) == 1
    assert area_under_curve(np.array([0.3, 9.0])) == 0


def test_what_turns_over(twins):
    source, target = twins.source_shape, twins.target_shape
    assert turned_over(source, target, twins.true) < 0.01
    assert turned_over(source, Mesh(target.vertices, target.faces[:, [0, 2, 1]]), twins.true) > 0.99
    assert turned_over(source, target, np.zeros_like(twins.true)) == 0  # all collapse


def test_what_is_not_reached_is_what_lies_far_from_all_that_is():
    side = np.linspace(0, 1, 41)
    points = np.stack([*np.meshgrid(side, side), np.zeros((41, 41))], axis=-1).reshape(-1, 3)
    mass = np.ones(len(points))
    left = np.flatnonzero(points[:, 0] < 0.701)
    assert unreached(points, mass, left, 0.04) == pytest.approx(11 / 41)
    assert unreached(points, mass, left[::3], 0.12) == pytest.approx(8 / 41, abs=1 / 41)  # a coarser shape, the same
    assert unreached(points, mass, left, 0.5) == 0
