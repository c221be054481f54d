from importlib import import_module

import numpy as np
import pytest

from lssd_learn.collections import Bodies
from lssd_learn.errors import InputError
from lssd_learn.maps import euclidean_errors, flipped, registration
from lssd_learn.maps.registration import from_afar, from_near, nearest_vertices, registered
from lssd_learn.shapes import Mesh, PointCloud, eigenbasis


def blurred(basis, shape, true, size, seed=0):
    """A map that is off by about `size`: the nearest vertices to points moved at random, and any way back."""
    rng = np.random.default_rng(seed)
    moved = shape.vertices[true] + size * rng.normal(size=(len(true), 3))
    away = np.linalg.norm(moved[:, None] - shape.vertices, axis=2)
    return away.argmin(axis=1), away.argmin(axis=0)


def test_shapes_that_stand_alike_need_no_first_map(shuffled):
    """Two bodies in one pose; one round bends hardly at all."""
    first, second = Bodies(n=9, topology="notoes_collapse5pc")[0], Bodies(n=9, topology="notoes_collapse5pc")[8]
    other, true = shuffled(second)
    a, b = eigenbasis(first, 60), eigenbasis(other, 60)
    errors = []
    for rounds in (1, 12):
        found = registered(a, b, first, other, *nearest_vertices(a, b, first, other), from_afar(rounds, 80))
        assert [len(some) for some in found] == [615, 615]
        errors.append(euclidean_errors(first, found[0], true).mean())
    assert errors[1] < 0.04
    assert errors[1] < 0.7 * errors[0]
    for changes, message in (({"rounds": 0}, "rounds=0: expected"), ({"functions": 3}, "functions=3: expected")):
        with pytest.raises(InputError, match=message):
            registration(a, b, first, other, **changes)


@pytest.mark.parametrize("cloud", [False, True])
def test_a_blurred_map_becomes_sharp(bodies, cloud):
    source, target = bodies.source_shape, bodies.target_shape
    goal, basis = target, bodies.target
    if cloud:
        goal = PointCloud(target.vertices)
        basis = eigenbasis(goal, 60)
    there, back = blurred(bodies.source, source, bodies.true, 0.06)
    before = euclidean_errors(source, there, bodies.true).mean()
    found, way_back = registered(bodies.source, basis, source, goal, there, back, from_near(12, 80))
    after = euclidean_errors(source, found, bodies.true).mean()
    assert after < 0.75 * before
    assert flipped(bodies.side, found, bodies.true) < 0.01
    assert euclidean_errors(source, found[way_back], np.arange(len(way_back))).mean() < 0.03


def test_a_shape_in_other_order_is_found_again_wherever_it_stands(twins):
    turn = np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1.0]])
    moved = Mesh(twins.target_shape.vertices @ turn + [5, 0, 1], twins.target_shape.faces)
    there, back = blurred(twins.source, twins.source_shape, twins.true, 0.05)
    found, way_back = registered(twins.source, twins.target, twins.source_shape, moved, there, back, from_afar(12, 50))
    assert (found == twins.true).mean() > 0.95
    assert (found[way_back] == np.arange(len(way_back))).mean() > 0.95
    clouds = [PointCloud(shape.vertices) for shape in (twins.source_shape, moved)]
    found, _ = registered(twins.source, twins.target, *clouds, there, back, from_afar(12, 80))
    assert (found == twins.true).mean() > 0.8


def test_stiffness_withstands_a_blurred_map(bodies, monkeypatch):
    """Points that are off pull the surface about; what bends stiffly follows their mean."""
    module = import_module("lssd_learn.maps.registration")  # the room has a function of that name
    source, target = bodies.source_shape, bodies.target_shape
    there, back = blurred(bodies.source, source, bodies.true, 0.2)
    errors = []
    for stiffness in (module.STIFFNESS, 0.0):
        monkeypatch.setattr(module, "STIFFNESS", stiffness)
        found, _ = registered(bodies.source, bodies.target, source, target, there, back, [60] * 8)
        errors.append(euclidean_errors(source, found, bodies.true).mean())
    assert errors[0] < 0.5 * errors[1]
