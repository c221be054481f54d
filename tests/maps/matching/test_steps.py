"""The steps of matching, each by a law of its own."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
import trimesh
from scipy.spatial.distance import cdist
from scipy.spatial.transform import Rotation

from lssd_learn.maps.matching.curvatures import SCALES
from lssd_learn.maps.matching.elastic import _nearer
from lssd_learn.maps.matching.features import features
from lssd_learn.maps.matching.lattice import mesh_elastic
from lssd_learn.maps.matching.likelihood import drawn, whitened
from lssd_learn.maps.matching.measures import Measures, chosen, quality, score
from lssd_learn.maps.matching.prepared import ENDS, prepared
from lssd_learn.maps.matching.spectral import fitted, nearest
from lssd_learn.maps.matching.surface import on_faces
from lssd_learn.shapes import Mesh, eigenbasis

TURN = Rotation.from_rotvec([0.4, 1.0, -2.0]).as_matrix()


@pytest.fixture(scope="module")
def body(twins):
    return prepared(twins.source_shape, twins.source)


def test_a_shape_is_prepared_at_unit_area(twins, body):
    assert body.basis.area == pytest.approx(1)
    np.testing.assert_allclose(body.basis.mass @ body.points, 0, atol=1e-12)
    assert len(np.unique(body.ends)) == ENDS
    assert (body.paths[np.arange(ENDS), body.ends] == 0).all()
    bigger = Mesh(3 * twins.source_shape.vertices, twins.source_shape.faces)
    again = prepared(bigger, type(twins.source)(twins.source.evals / 9, twins.source.evecs / 3, 9 * twins.source.mass))
    np.testing.assert_allclose(again.points, body.points)
    np.testing.assert_allclose(again.paths, body.paths)
    np.testing.assert_array_equal(again.ends, body.ends)


def test_the_mirror_image_has_the_same_looks_but_for_the_sided_ones_sign(twins, body):
    image = Mesh(twins.source_shape.vertices * [1, -1, 1], twins.source_shape.faces[:, [0, 2, 1]])
    mine, theirs = features(body, prepared(image, twins.source))
    np.testing.assert_allclose(mine.plain, theirs.plain, atol=1e-9)
    np.testing.assert_allclose(mine.sided, -theirs.sided, atol=1e-9)
    assert np.abs(mine.sided).max() > 0.1
    turned = Mesh(twins.source_shape.vertices @ TURN.T, twins.source_shape.faces)
    mine, theirs = features(body, prepared(turned, twins.source))
    np.testing.assert_allclose(mine.sided, theirs.sided, atol=1e-9)


def test_the_two_sides_of_a_body_look_alike_only_to_the_plain_ones(twins, body):
    left = np.flatnonzero(twins.side > 0.1)
    mirrored = twins.source_shape.vertices[left] * [-1, 1, 1]
    right = cdist(mirrored, twins.source_shape.vertices).argmin(axis=1)
    look, _ = features(body, body)
    assert np.corrcoef(look.plain[left].ravel(), look.plain[right].ravel())[0, 1] > 0.9
    assert np.corrcoef(look.sided[left].ravel(), look.sided[right].ravel())[0, 1] < -0.5


def test_nearest_rows_and_least_squares():
    rng = np.random.default_rng(0)
    A, B = rng.standard_normal((50, 7)).astype(np.float32), rng.standard_normal((1500, 7)).astype(np.float32)
    np.testing.assert_array_equal(nearest(A, B), cdist(B, A).argmin(axis=1))
    P, C = rng.standard_normal((60, 5)), rng.standard_normal((5, 4))
    np.testing.assert_allclose(fitted(P, P @ C), C, atol=1e-4)


def test_moving_and_turning_costs_nothing_and_stretching_something(body):
    elastic = mesh_elastic(body)
    moved = body.points @ TURN.T + [1.0, 2.0, 3.0]
    got = elastic.fit(moved, body.basis.mass, 0.01, moved)
    np.testing.assert_allclose(got, moved, atol=1e-8)
    assert elastic.energy(got) == pytest.approx(0, abs=1e-12)
    longer = body.points * [1.0, 1.0, 1.2]
    got = elastic.fit(longer, body.basis.mass, 1e-6, longer)
    assert elastic.energy(got) > 1e-3


def test_newtons_steps_find_the_rotation_of_a_polar_decomposition():
    rng = np.random.default_rng(0)
    true = Rotation.random(50, rng=rng).as_matrix()
    start = true @ Rotation.from_rotvec(0.2 * rng.standard_normal((50, 3))).as_matrix()
    shapes = rng.standard_normal((50, 3, 3))
    covariances = (shapes @ shapes.transpose(0, 2, 1) + 0.3 * np.eye(3)) @ true
    off = [np.abs(start - true).max()]
    for _ in range(5):
        start = _nearer(start, covariances)
        np.testing.assert_allclose(start @ start.transpose(0, 2, 1), np.broadcast_to(np.eye(3), (50, 3, 3)), atol=1e-12)
        off.append(np.abs(start - true).max())
    assert off[-1] < 1e-6 < off[0]


def test_a_stretch_is_learnt(body):
    elastic = mesh_elastic(body)
    bigger = 1.2 * body.points @ TURN.T
    stiff = elastic.fit(bigger, body.basis.mass, 10.0, bigger)
    before = np.linalg.norm(stiff - bigger, axis=1).mean()
    for _ in range(3):
        elastic.fit(bigger, body.basis.mass, 1e-4, bigger)
        elastic.learn(bigger)
    after = np.linalg.norm(elastic.fit(bigger, body.basis.mass, 10.0, bigger) - bigger, axis=1).mean()
    assert after < 0.2 * before


def test_curvatures_of_spheres_and_planes_are_known():
    ball = trimesh.creation.icosphere(4, radius=1 / np.sqrt(4 * np.pi))
    sphere = prepared(Mesh(ball.vertices, ball.faces), eigenbasis(Mesh(ball.vertices, ball.faces), 40))
    r, t = np.sqrt(1 / (4 * np.pi)), SCALES
    # Coordinates are eigenfunctions of 2 / r²: a step of heat flow shortens x, and n = x / r, by 1 / (1 + 2 t / r²).
    shorter = 1 / (1 + 2 * t / r**2)
    np.testing.assert_allclose(sphere.curvatures[:, ::2], np.tile((shorter - 1) * r / np.sqrt(t), (2562, 1)), rtol=0.03)
    np.testing.assert_allclose(sphere.curvatures[:, 1::2], np.tile(shorter, (2562, 1)), rtol=0.03)


def test_curvatures_turn_with_the_shape(twins, body):
    turned = Mesh(twins.source_shape.vertices @ TURN.T, twins.source_shape.faces)
    np.testing.assert_allclose(prepared(turned, twins.source).curvatures, body.curvatures, atol=1e-8)


def test_a_look_that_noise_spoils_is_not_listened_to():
    """Two looks, each the place on a line; one with a hundred times the noise: whitened, the other decides."""
    rng = np.random.default_rng(0)
    line = np.linspace(0, 1, 400)
    noise = rng.standard_normal((2, 400, 2)) * [0.005, 0.6]
    one, other = ((line[:, None] + off).astype(np.float32) for off in noise)
    same, even = np.arange(400), (np.full(400, 1 / 400),) * 2
    mine, theirs = whitened((one, other), same, same, even)
    off = mine - theirs
    np.testing.assert_allclose(np.cov(off.T), 0.5 * np.eye(2), atol=0.04)  # of one size, and of no direction
    plain = np.abs(line[nearest(one, other)] - line).mean()
    heard = np.abs(line[nearest(mine.astype(np.float32), theirs.astype(np.float32))] - line).mean()
    assert heard < 0.5 * plain


def test_looks_that_are_the_same_all_over_do_no_harm():
    """As those of a ring, along which nothing changes."""
    flat = np.full((40, 3), 0.7, dtype=np.float32)
    line = np.column_stack([np.linspace(0, 1, 40, dtype=np.float32), flat])
    mine, theirs = whitened((line, line), np.arange(40), np.arange(40), (np.full(40, 1 / 40),) * 2)
    assert np.isfinite(mine).all()
    np.testing.assert_array_equal(nearest(mine.astype(np.float32), theirs.astype(np.float32)), np.arange(40))


def test_points_are_drawn_to_likely_partners():
    """Where place and normal are no help, as along a tube, looks pull points along the surface."""
    n = 60
    angle = 2 * np.pi * np.arange(n) / n
    circle = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1) * 0.1
    along = np.roll(circle, 1, axis=0)  # each a step from where it belongs
    even, flat = (np.full(n, 1 / n),) * 2, 0 * circle
    step = (np.arange(n) + 1) % n, (np.arange(n) - 1) % n  # as the nearest have it
    looks = (circle.astype(np.float32),) * 2
    weights, _, there, back = drawn((along, flat), (circle, flat), looks, step, even)
    assert weights.sum() == pytest.approx(2)
    np.testing.assert_array_equal(there, np.arange(n))
    np.testing.assert_array_equal(back, np.arange(n))
    _, places, _, _ = drawn((along, flat), (circle, flat), looks, (there, back), even)
    np.testing.assert_allclose(places, circle, atol=1e-9)
    _, places, there, _ = drawn((along, flat), (circle, flat), (0 * looks[0],) * 2, step, even)
    np.testing.assert_array_equal(there, step[0])  # without looks
    np.testing.assert_allclose(places, along, atol=3e-3)  # a mean of near ones, a little inside


def test_a_map_with_a_rival_is_not_trusted(body):
    seen = Measures(energy=0.05, gap=0.01, facing=0.02, trip=0.005, uncovered=0.2, turned=0.03, unlike=0.7)
    way, other = (SimpleNamespace(there=order) for order in (np.arange(615), np.arange(615)[::-1]))
    alone, twice = chosen(body, [(way, seen)]), chosen(body, [(way, seen), (way, seen)])
    rival = chosen(body, [(other, replace(seen, energy=0.055)), (way, seen)])
    assert rival[0] is way
    assert rival[2] < 0.5 < alone[2] == twice[2]
    assert score(replace(seen, unlike=0.8)) < score(seen)


def test_points_of_a_surface_are_found_again(twins):
    mesh, rng = twins.source_shape, np.random.default_rng(1)
    faces, weights = rng.integers(len(mesh.faces), size=200), rng.dirichlet([1, 1, 1], 200)
    wanted = np.einsum("nc,ncx->nx", weights, mesh.vertices[mesh.faces[faces]])
    near = cdist(wanted, mesh.vertices).argsort(axis=1)[:, :3]
    found, coordinates = on_faces(mesh.faces, mesh.vertices, near, wanted)
    places = np.einsum("nc,ncx->nx", coordinates, mesh.vertices[mesh.faces[found]])
    assert (coordinates >= 0).all()
    np.testing.assert_allclose(coordinates.sum(axis=1), 1)
    assert np.median(np.linalg.norm(places - wanted, axis=1)) < 1e-9
    assert np.linalg.norm(places - wanted, axis=1).max() < 0.05


def test_a_map_that_does_badly_is_not_trusted_however_far_ahead_nor_one_with_an_equal_rival():
    assert quality(55, 3) > 0.9
    assert quality(36, 20) < 0.01
    assert quality(60, 0) < 0.3
    assert quality(50, 2) < quality(50, 3) < quality(52, 3)
