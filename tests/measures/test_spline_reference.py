"""The thin-plate spline through the other landmarks: exact where shapes differ by an affine map, and only there."""

import numpy as np

from lssd_learn.measures.spline_reference import spline_errors


def test_affine_images_are_foretold_exactly_and_a_bump_is_not():
    rng = np.random.default_rng(0)
    base = rng.normal(size=(9, 3))
    images = np.array([base @ rng.normal(size=(3, 3)) + rng.normal(size=3) for _ in range(5)])
    found = spline_errors(images[:2], images[2:])
    np.testing.assert_allclose(found, 0, atol=1e-6)
    off = images[2:].copy()
    off[0, 4, 0] += 1.0
    found = spline_errors(images[:2], off)
    assert 0.9 < found[0, 4] < 1.1  # the others do not know of it
    assert (found[0, [0, 1, 2, 3, 5, 6, 7, 8]] > 1e-3).all()  # but are misled by it
    np.testing.assert_allclose(found[1:], 0, atol=1e-6)


def test_two_landmarks_at_one_point_are_no_matter_and_too_few_say_nothing():
    base = np.random.default_rng(1).normal(size=(8, 3))
    base[3] = base[5]
    np.testing.assert_allclose(spline_errors(base[None], 2 * base[None] + 1), 0, atol=1e-5)
    assert spline_errors(base[None, :5], base[None, :5]) is None
    flat = base * [1, 1, 0]
    assert spline_errors(flat[None], flat[None]) is None
