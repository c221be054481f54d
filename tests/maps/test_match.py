"""Shapes matched as they lie: a turned copy is found again, a mirrored one named, points lie on faces."""

import sys

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from lssd_learn.collections import Bodies
from lssd_learn.errors import InputError
from lssd_learn.maps import euclidean_errors, flipped, match
from lssd_learn.maps.match import matched, ready
from lssd_learn.maps.matching.candidates import candidates
from lssd_learn.maps.matching.measures import score
from lssd_learn.shapes import Mesh, PointCloud, eigenbasis

TURN = Rotation.from_rotvec([1.1, -2.0, 0.7]).as_matrix()


@pytest.fixture(scope="module")
def turned(twins):
    """The shuffled copy of a body, turned and moved."""
    return Mesh(twins.target_shape.vertices @ TURN.T + [3.0, -1.0, 2.0], twins.target_shape.faces)


@pytest.fixture(scope="module")
def found(twins, turned):
    return match(twins.source_shape, turned)


def test_a_turned_copy_is_found_again(twins, turned, found):
    assert euclidean_errors(twins.source_shape, found.vertices, twins.true).mean() < 1e-3
    assert flipped(twins.side, found.vertices, twins.true) == 0
    assert found.quality > 0.9
    assert not found.mirrored
    np.testing.assert_allclose(found.rotation, TURN, atol=0.01)


def test_points_lie_on_faces(twins, turned, found):
    assert found.faces.shape == (615,)
    assert found.barycentric.shape == (615, 3)
    assert (found.barycentric >= 0).all()
    np.testing.assert_allclose(found.barycentric.sum(axis=1), 1)
    np.testing.assert_array_equal(found.corners, twins.source_shape.faces[found.faces])
    assert (found.vertices[:, None] == found.corners).any(axis=1).all()
    np.testing.assert_allclose(found.carried(np.ones(615)), 1)
    places = found.carried(twins.source_shape.vertices) @ TURN.T + [3.0, -1.0, 2.0]
    size = np.sqrt(twins.source.area)
    assert np.linalg.norm(places - turned.vertices, axis=1).mean() < 2e-3 * size


def test_its_functional_map_is_that_of_the_truth(twins, found):
    C = found.functional(twins.source, twins.target)
    np.testing.assert_allclose(np.abs(np.diag(C)[:20]), 1, atol=0.02)
    with pytest.raises(ValueError, match="expected a basis of 615 vertices"):
        found.functional(twins.target, eigenbasis(Bodies(n=1, topology="notoes_collapse3pc")[0], 5))


def test_two_people_in_two_poses():
    bodies = Bodies(n=11, topology="notoes_collapse5pc")
    source, target = bodies[2], bodies[8]  # one connectivity: the truth is the identity, which match does not look for
    target = Mesh(target.vertices @ TURN.T, target.faces)
    found = match(source, target)
    error = euclidean_errors(source, found.vertices, np.arange(615)).mean()
    assert error < 0.05, error
    assert flipped(bodies.make({}).vertices[:, 0], found.vertices, np.arange(615)) < 0.02


def test_a_mirrored_copy_is_named_where_it_may_be(twins):
    x, y, z = twins.source_shape.vertices.T
    lopsided = Mesh(
        np.stack([x, y * (1 + 0.5 * np.tanh(3 * x)), z * (1 - 0.3 * np.tanh(3 * x))], axis=1), twins.source_shape.faces
    )
    image = Mesh(lopsided.vertices * [-1, 1, 1] @ TURN.T, lopsided.faces[:, [0, 2, 1]])
    found = match(lopsided, image, mirror="allow")
    assert found.mirrored
    assert np.mean(found.vertices == np.arange(615)) > 0.99
    places = found.carried(lopsided.vertices)
    assert np.linalg.norm(places - lopsided.vertices, axis=1).mean() < 2e-3
    assert np.linalg.det(found.rotation) == pytest.approx(1)
    assert not match(lopsided, lopsided, mirror="allow").mirrored


def test_faces_that_point_inward_do_not_swap_the_sides(twins, turned, found):
    inverted = Mesh(twins.source_shape.vertices, twins.source_shape.faces[:, [0, 2, 1]])
    again = match(inverted, turned, twins.source, twins.target)
    np.testing.assert_array_equal(again.vertices, found.vertices)
    np.testing.assert_allclose(again.carried(inverted.vertices), found.carried(inverted.vertices), atol=1e-3)


def test_what_cannot_be_matched_is_refused(twins):
    cloud = PointCloud(twins.source_shape.vertices)
    with pytest.raises(InputError, match="match: expected meshes, .* got a cloud"):
        match(twins.source_shape, cloud, twins.source, twins.source)
    tetrahedron = Mesh(np.eye(4)[:, :3], [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])
    with pytest.raises(InputError, match="match: expected 30 eigenfunctions or more, got 3"):
        match(twins.source_shape, tetrahedron, twins.source)
    with pytest.raises(InputError, match="mirror=perhaps: expected one of forbid, allow"):
        match(twins.source_shape, twins.target_shape, mirror="perhaps")


def test_what_is_doubtful_is_looked_at_again(twins, turned, monkeypatch):
    source, target = (ready(shape) for shape in (twins.source_shape, turned))
    asked = []

    def few(source, target, every=False, tried=4):
        """As if the right start had been given up at first."""
        asked.append((every, tried))
        found = sorted(candidates(source, target, every=True), key=lambda way: score(way[1]))
        return found if every else found[:1]

    monkeypatch.setattr(sys.modules[matched.__module__], "candidates", few)
    found = matched(source, target)
    assert asked == [(False, 4), (True, 8)]
    assert euclidean_errors(twins.source_shape, found.bent.there, twins.true).mean() < 1e-3
    assert found.quality > 0.9
