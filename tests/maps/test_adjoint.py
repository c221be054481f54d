"""The pair of maps against a dense solution of the same least squares, and what the regularisation promises."""

import numpy as np
import pytest

from lssd_learn.errors import InputError
from lssd_learn.maps import adjoint, euclidean_errors, flipped, from_correspondence, to_vertices
from lssd_learn.maps.probes import probes
from lssd_learn.shapes import Eigenbasis
from lssd_learn.shapes.descriptors import at_unit_area


def dense(source, target, marks, a, c, e1, e2):
    """Every term as rows of one least squares problem in all entries of both maps; unit area."""
    s, t = at_unit_area(source), at_unit_area(target)
    A, B = probes(s, t, *marks)
    k, l = s.k, t.k
    gap = (t.evals[:, None] - s.evals) ** 2
    gap /= (gap**2).sum()

    def residual(x):
        C1, C2 = x[: k * l].reshape(l, k), x[k * l :].reshape(k, l)
        return np.concatenate([part.ravel() for part in (
            np.sqrt(a) * (C1 @ A - B), np.sqrt(a) * (C2 @ B - A), np.sqrt(c * gap) * C1, np.sqrt(c * gap.T) * C2,
            np.sqrt(e1) * (C1 - C2.T), np.sqrt(e2) * (t.evals[:, None] * C1 - C2.T * s.evals),
        )])  # fmt: skip

    fixed = np.zeros(2 * k * l, dtype=bool)
    fixed[: k * l].reshape(l, k)[:, 0] = fixed[k * l :].reshape(k, l)[:, 0] = True
    start = np.zeros(2 * k * l)
    start[[0, k * l]] = np.sign(source.evecs[0, 0] * target.evecs[0, 0])
    at_start = residual(start)
    columns = np.stack([residual(start + unit) - at_start for unit in np.eye(2 * k * l)[~fixed]], axis=1)
    start[~fixed] = np.linalg.lstsq(columns, -at_start)[0]
    return start[: k * l].reshape(l, k), start[k * l :].reshape(k, l)


@pytest.mark.parametrize("sizes", [(6, 6), (5, 7)])
@pytest.mark.parametrize("weights", [(0.5, 1e-3, 500.0, 4.5e-7), (1.0, 10.0, 2.0, 1e-3)])
def test_conjugate_gradients_find_the_dense_solution(bodies, sizes, weights):
    source, target = bodies.source.truncate(sizes[0]), bodies.target.truncate(sizes[1])
    marks = bodies.source_landmarks, bodies.target_landmarks
    C1, C2 = adjoint(source, target, *marks, *weights)
    scale = np.sqrt(target.area / source.area)
    for found, expected in zip((C1 / scale, C2 * scale), dense(source, target, marks, *weights), strict=True):
        np.testing.assert_allclose(found, expected, atol=1e-6)


def test_the_maps_are_adjoint_and_carry_constants(bodies):
    C1, C2 = adjoint(bodies.source, bodies.target, bodies.source_landmarks, bodies.target_landmarks)
    ratio = bodies.target.area / bodies.source.area
    np.testing.assert_allclose(C1 / np.sqrt(ratio), (C2 * np.sqrt(ratio)).T, atol=2e-3)
    np.testing.assert_allclose(C1[:, 0], np.sqrt(ratio) * np.eye(60)[0], atol=1e-14)
    np.testing.assert_allclose(C2[:, 0], np.eye(60)[0] / np.sqrt(ratio), atol=1e-14)


def test_a_shuffled_copy_is_recovered(twins):
    C1, C2 = adjoint(twins.source, twins.target, twins.source_landmarks, twins.target_landmarks)
    np.testing.assert_allclose(C1, from_correspondence(twins.source, twins.target, twins.true), atol=0.05)
    assert (to_vertices(twins.source, twins.target, C1) == twins.true).mean() > 0.99
    assert (to_vertices(twins.target, twins.source, C2) == np.argsort(twins.true)).mean() > 0.99


def test_exchanging_the_shapes_exchanges_the_maps(bodies):
    there = adjoint(bodies.source, bodies.target, bodies.source_landmarks, bodies.target_landmarks)
    back = adjoint(bodies.target, bodies.source, bodies.target_landmarks, bodies.source_landmarks)
    for C, expected in zip(back[::-1], there, strict=True):
        np.testing.assert_allclose(C, expected, atol=1e-5)


def test_signs_of_eigenfunctions_go_along(bodies):
    """Those of the constants too."""
    marks = bodies.source_landmarks, bodies.target_landmarks
    signs = np.where(np.arange(60) % 3, 1, -1)
    target = bodies.target
    turned = Eigenbasis(target.evals, target.evecs * signs, target.mass)
    C1, C2 = adjoint(bodies.source, target, *marks)
    T1, T2 = adjoint(bodies.source, turned, *marks)
    np.testing.assert_allclose(T1, signs[:, None] * C1, atol=1e-5)
    np.testing.assert_allclose(T2, C2 * signs, atol=1e-5)


def test_bodies_of_two_connectivities(bodies):
    source, target = bodies.source.truncate(40), bodies.target.truncate(40)
    C, _ = adjoint(source, target, bodies.source_landmarks, bodies.target_landmarks)
    found = to_vertices(source, target, C)
    assert euclidean_errors(bodies.source_shape, found, bodies.true).mean() < 0.04
    assert flipped(bodies.side, found, bodies.true) < 0.02


def test_what_does_not_fit_is_refused(twins):
    with pytest.raises(InputError, match="landmarks: expected as many on both shapes, got 1 and 0"):
        adjoint(twins.source, twins.target, [3])
