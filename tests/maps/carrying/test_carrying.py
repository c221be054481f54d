"""Landmarks carried by maps: exact where the truth is a motion, robust against hubs that are off, doubtful where they
disagree."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from lssd_learn.collections import Bumps, ShapeList
from lssd_learn.maps.carrying.carry import carry, pairs_of
from lssd_learn.maps.carrying.consensus import consensus
from lssd_learn.maps.carrying.doubts import doubts, unrest
from lssd_learn.maps.carrying.patches import Laid, laid
from lssd_learn.maps.carrying.settled import Surface, patches
from lssd_learn.maps.pairs import PairMaps
from lssd_learn.shapes import Mesh

BUMPY = Bumps(places={"a": (1, 0, 0), "b": (0, 1, 1), "c": (-1, 2, -1)}, heights=[(0.5, 0.2, 0.3)], widths=[40, 30, 50],
              subdivisions=2)[0]  # fmt: skip
POINTS = BUMPY.vertices[[0, 7, 100]] * [[1.05], [0.9], [1.0]]  # above the surface, below and on it


def moved(seed: int, mirrored: bool, scale: float = 1.0) -> tuple[Mesh, np.ndarray, np.ndarray]:
    """The bumpy sphere moved, its vertices in another order; its landmarks, and the new number of each vertex."""
    rng = np.random.default_rng(seed)
    motion = scale * Rotation.random(rng=rng).as_matrix() * ([-1, 1, 1] if mirrored else [1, 1, 1])
    shift, order = rng.normal(size=3), rng.permutation(len(BUMPY.vertices))
    new = np.argsort(order)
    faces = new[BUMPY.faces]
    points = BUMPY.vertices @ motion.T + shift
    return Mesh(points[order], faces[:, ::-1] if mirrored else faces), POINTS @ motion.T + shift, new


def in_corners(vertices: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A vertex map as points of triangles."""
    return np.repeat(vertices[:, None], 3, axis=1), np.tile([0.5, 0.25, 0.25], (len(vertices), 1))


@settings(max_examples=10, deadline=None)
@given(seed=st.integers(0, 99), mirrored=st.booleans(), scale=st.sampled_from([0.1, 1.0, 30.0]))
def test_a_motion_carries_points_exactly_on_the_surface_and_off_it(seed, mirrored, scale):
    target, true, new = moved(seed, mirrored, scale)
    found = laid(POINTS, BUMPY, target, *in_corners(new)).points
    np.testing.assert_allclose(found, true, atol=1e-9 * scale)


def test_a_point_off_a_bent_surface_stays_off_it_as_far():
    bent = Bumps(heights=[(0.4, 0.1)], widths=[60, 60], subdivisions=4)[0]
    ball = Bumps(heights=[(0, 0)], widths=[60, 60], subdivisions=4)[0]
    some = np.arange(0, 2562, 500)
    found = laid(1.1 * ball.vertices[some], ball, bent, *in_corners(np.arange(2562))).points
    away = np.linalg.norm(found - bent.vertices[some], axis=1)
    np.testing.assert_allclose(away, 0.1, atol=0.012)  # patches are not flat
    assert (np.linalg.norm(found, axis=1) > np.linalg.norm(bent.vertices[some], axis=1)).all()


def test_consensus_is_nearly_the_mean_and_moves_with_the_places():
    rng = np.random.default_rng(0)
    places = rng.normal(size=(7, 5, 3))
    found = consensus(places)
    assert np.linalg.norm(found.points - places.mean(axis=0), axis=1).max() < 0.3
    turn, shift = Rotation.random(rng=rng).as_matrix(), rng.normal(size=3)
    other = consensus(10 * places @ turn + shift)
    np.testing.assert_allclose(other.points, 10 * found.points @ turn + shift, atol=1e-6)
    np.testing.assert_allclose(other.spread, 10 * found.spread, rtol=1e-6)


@pytest.mark.parametrize("far", [5.0, 100.0])
def test_one_hub_that_is_off_moves_nothing_and_the_spread_little(far):
    rng = np.random.default_rng(1)
    places = 0.1 * rng.normal(size=(7, 4, 3))
    wrong = places.copy()
    wrong[3, 2] += far
    clean, found = consensus(places), consensus(wrong)
    others = np.delete(places[:, 2], 3, axis=0).mean(axis=0)
    assert np.linalg.norm(found.points[2] - others) < 0.06 < np.linalg.norm(wrong[:, 2].mean(axis=0) - others)
    assert clean.spread[2] < found.spread[2] < 2 * clean.spread[2]


def test_what_nobody_says_is_nowhere_and_one_alone_has_no_spread():
    places = np.full((3, 3, 3), np.nan)
    places[0, 1:], places[1:, 2] = 1.0, 1.0
    found = consensus(places)
    assert np.isnan(found.points[0]).all()
    np.testing.assert_array_equal(found.points[1:], 1.0)
    np.testing.assert_array_equal(found.count, [0, 1, 3])
    np.testing.assert_array_equal(np.isnan(found.spread), [True, True, False])


def test_error_bars_are_in_the_order_of_the_noise_and_of_its_size():
    rng, noise = np.random.default_rng(2), np.array([0.02, 0.1, 0.5])
    known = rng.normal(size=(8, 3, 3))
    places = known[:, None] + noise[:, None] * rng.normal(size=(8, 8, 3, 3))
    places[np.arange(8), np.arange(8)] = np.nan
    found = [consensus(row) for row in places]
    errors = np.linalg.norm([one.points for one in found] - known, axis=2)
    told = doubts(errors, np.array([unrest(one, one) for one in found]))
    calm = told.bars(np.sqrt(told.unrest)[None])[0]
    assert (np.diff(calm) > 0).all()
    assert 0.5 < calm[2] / (0.5 * np.sqrt(3 / 7)) < 2  # of the mean of seven
    np.testing.assert_allclose(told.bars(2 * np.sqrt(told.unrest)[None])[0], np.sqrt(2) * calm)
    slip = errors.copy()
    slip[4, 1] = 50.0
    other = doubts(slip, np.array([unrest(one, one) for one in found]))
    assert other.slips[0] == (4, 1)
    assert other.square[1] < 1  # one slip of a hand is not what is to be expected


def test_two_shapes_tell_nothing_of_errors():
    assert doubts(np.zeros((2, 1)), np.full((2, 1), np.nan)) is None


class _Known(PairMaps):
    """True maps of moved spheres, one of which is not to be trusted."""

    level = 0.5

    def __init__(self, numbers, bad):
        self.numbers, self.bad = numbers, bad

    def points(self, i, j):
        return in_corners(self.numbers[i][np.argsort(self.numbers[j])])

    def quality(self, i, j):
        return 0.1 if self.bad in (i, j) else 0.9


def test_maps_that_are_not_trusted_carry_nothing():
    made = [moved(seed, mirrored=seed == 2) for seed in range(6)]
    shapes, maps = ShapeList([mesh for mesh, _, _ in made]), _Known([new for _, _, new in made], bad=5)
    known = np.array([marks for _, marks, _ in made[:3]])
    known[1, 0] = np.nan
    found = carry(shapes, maps, [0, 1, 2], [3, 4, 5, 1], known)
    for number, i in enumerate([3, 4]):
        np.testing.assert_allclose(found.points[number], made[i][1], atol=1e-8)
    assert np.isnan(found.points[2]).all()
    assert found.lost == [5]
    np.testing.assert_allclose(found.points[3], made[1][1], atol=1e-8)  # a hub hears of the others
    np.testing.assert_array_equal(found.found[0].count, [2, 3, 3])
    assert (found.bars[0] < 1e-6).all()


def test_pairs_are_those_with_hubs():
    assert pairs_of([2, 0], [1, 3]) == [(0, 1), (0, 2), (0, 3), (1, 2), (2, 3)]


def test_a_patch_settles_where_its_form_fits():
    ball = Bumps(places={"a": (1, 0, 0.3)}, heights=[(0.4,)], widths=[25], subdivisions=4)[0]
    motion = 3 * Rotation.random(rng=np.random.default_rng(3)).as_matrix() * [-1, 1, 1]
    target = Mesh(ball.vertices @ motion.T, ball.faces[:, ::-1])
    tip = 1.05 * ball.vertices[np.argmax(np.linalg.norm(ball.vertices, axis=1))][None]
    true, turns = tip @ motion.T, motion.T[None] / 3
    start = true + 0.1 * np.array([[0.3, -0.5, 0.4]])
    found = Surface(target).settled(patches(tip, ball, 0.2), Laid(start, turns, 3.0), start)
    assert np.linalg.norm(found - true) < 0.2 * np.linalg.norm(start - true)
    nowhere = Surface(target).settled(patches(tip, ball), Laid(start, turns, 3.0), np.full((1, 3), np.nan))
    assert np.isnan(nowhere).all()
