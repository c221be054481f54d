"""Matching without anything given: near the truth, upright shapes not flipped, each point once."""

import numpy as np
import pytest
from scipy.optimize import linear_sum_assignment
from scipy.spatial.transform import Rotation

from lssd_learn.errors import InputError
from lssd_learn.maps import euclidean_errors, flipped, from_correspondence, kernel_matching
from lssd_learn.maps.kernel_matching import KernelMatching, Matched, _standard, densified, match
from lssd_learn.maps.probes import ENERGIES
from lssd_learn.shapes import Mesh, PointCloud, eigenbasis
from lssd_learn.shapes.descriptors import at_unit_area, wave_bounds, wave_kernel_signature
from lssd_learn.shapes.sampling import spread


def ends(pair):
    return pair.source, pair.target, pair.source_shape, pair.target_shape


@pytest.fixture(scope="module")
def points(twins):
    return match(*ends(twins), KernelMatching(samples=400))


def test_every_point_is_matched_once(points):
    for W in (points.source, points.target):
        assert W.shape == (400, 615)
        np.testing.assert_allclose(W.sum(axis=1), 1)
        assert len(np.unique(W.toarray(), axis=0)) == 400


def test_a_shuffled_copy(twins, points):
    spacing = np.sqrt(1 / 400)
    off = np.linalg.norm(
        points.source @ twins.source_shape.vertices - points.target @ twins.target_shape.vertices, axis=1
    )
    assert off.mean() < spacing * np.sqrt(twins.source.area)
    for refined, bound in ((None, 0.02), (50, 0.01)):
        found = densified(twins.source, twins.target, points, refined=refined)
        assert euclidean_errors(twins.source_shape, found, twins.true).mean() < bound
        back = densified(twins.target, twins.source, points.reversed(), refined=refined)
        assert euclidean_errors(twins.target_shape, back, np.argsort(twins.true)).mean() < bound
        assert flipped(twins.side, found, twins.true) == 0


def test_exact_points_give_the_exact_map(twins):
    at_vertices = Matched(np.eye(615)[twins.true], np.eye(615))
    np.testing.assert_array_equal(densified(twins.source, twins.target, at_vertices), twins.true)


def test_bodies_of_two_connectivities(bodies):
    points = match(*ends(bodies), KernelMatching(samples=500))
    found = densified(bodies.source, bodies.target, points)
    assert euclidean_errors(bodies.source_shape, found, bodies.true).mean() < 0.03
    assert flipped(bodies.side, found, bodies.true) < 0.01
    C = kernel_matching(*ends(bodies), samples=500, registered=0)
    np.testing.assert_array_equal(C, from_correspondence(bodies.source, bodies.target, found))


def test_without_coordinates_only_the_intrinsic_shape_counts(bodies):
    turned = Mesh(
        bodies.target_shape.vertices @ Rotation.from_euler("x", 1.0).as_matrix() + 3, bodies.target_shape.faces
    )
    basis = eigenbasis(turned, 60)
    straight = match(*ends(bodies), KernelMatching(samples=200, extrinsic=0))
    other = match(bodies.source, basis, bodies.source_shape, turned, KernelMatching(samples=200, extrinsic=0))
    assert abs(straight.source - other.source).max() < 1e-6


def test_the_seed_chooses_the_points(bodies):
    first, again, other = (match(*ends(bodies), KernelMatching(samples=50, steps=1, seed=s)) for s in (0, 0, 1))
    assert abs(first.target - again.target).max() == 0
    assert abs(first.target - other.target).max() > 0


def test_a_cloud_and_a_mesh(twins):
    cloud = PointCloud(twins.target_shape.vertices)
    basis = eigenbasis(cloud, 50)
    points = match(twins.source, basis, twins.source_shape, cloud, KernelMatching(samples=300))
    found = densified(twins.source, basis, points)
    assert euclidean_errors(twins.source_shape, found, twins.true).mean() < 0.06
    every = match(twins.source, basis, twins.source_shape, cloud, KernelMatching(samples=700, steps=1))
    assert every.source.shape[0] == 615


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"samples": 1}, "samples=1: expected a whole number, 2 or more"),
        ({"steps": 0}, "steps=0: expected a whole number, 1 or more"),
        ({"smoothness": 0}, "smoothness=0: expected a number above 0"),
        ({"functions": 0, "samples": 9}, "functions=0: expected a whole number, 1 or more"),
    ],
)
def test_numbers_out_of_range_are_refused(twins, changes, message):
    with pytest.raises(InputError, match=message):
        kernel_matching(*ends(twins), **changes)


def match_naive(source, target, source_shape, target_shape, samples, steps):
    """Step by step as the formula has it, with whole kernels."""
    rng = np.random.default_rng(0)
    on_source, on_target = spread(source_shape, samples, rng), spread(target_shape, samples, rng)
    s, t = at_unit_area(source), at_unit_area(target)
    bounds = wave_bounds(s, t)
    signatures = [wave_kernel_signature(basis, ENERGIES, bounds) for basis in (s, t)]
    x, y = _standard(on_source @ signatures[0], on_target @ signatures[1])
    F, P = x @ y.T, None
    for time in (None, *np.geomspace(0.026, 0.0005, steps)):
        score = F
        if time is not None:
            K_X, K_Y = (W @ (b.evecs * np.exp(-time * b.evals)) @ b.evecs.T @ W.T
                        for W, b in ((on_source, s), (on_target, t)))  # fmt: skip
            score = F + K_X @ P @ K_Y.T / samples
        rows, columns = linear_sum_assignment(score, maximize=True)
        P = np.zeros((samples, samples))
        P[rows, columns] = 1
    return on_source[rows], on_target[columns]


def test_it_is_the_formula(bodies):
    """And not another weight of the kernels, nor their times from late to early: both give other points."""
    expected = match_naive(*ends(bodies), samples=120, steps=3)
    found = match(*ends(bodies), KernelMatching(samples=120, steps=3, extrinsic=0))
    for ours, theirs in zip((found.source, found.target), expected, strict=True):
        assert abs(ours - theirs).max() < 1e-12
    hardly = match(*ends(bodies), KernelMatching(samples=120, steps=3, extrinsic=0, smoothness=1e-9))
    assert abs(hardly.target - expected[1]).max() > 0


def test_the_size_of_either_shape_does_not_matter(bodies):
    """Heat spreads by area: the times are those at unit area, whatever the shapes are measured in."""
    large = Mesh(1000 * bodies.source_shape.vertices, bodies.source_shape.faces)
    points = match(*ends(bodies), KernelMatching(samples=150))
    for shapes in ((large, bodies.target_shape), (bodies.target_shape, large)):
        a, b = (eigenbasis(shape, 60) if shape is large else bodies.target for shape in shapes)
        other = match(a, b, *shapes, KernelMatching(samples=150))
        if shapes[0] is large:
            assert abs(other.source - points.source).max() < 1e-6
            assert abs(other.target - points.target).max() < 1e-6
        else:
            here = match(
                bodies.target, bodies.source, bodies.target_shape, bodies.source_shape, KernelMatching(samples=150)
            )
            assert abs(other.target - here.target).max() < 1e-6
