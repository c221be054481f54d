"""`maps=auto`: points inside triangles and the quality are kept with a pair, and bad maps are named."""

import logging

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from lssd_learn.cache import Cache
from lssd_learn.collections import Bodies, ShapeList
from lssd_learn.maps import AutoMaps, VertexMaps, match, named_maps
from lssd_learn.shapes import Mesh, PointCloud, eigenbasis


@pytest.fixture(scope="module")
def collection(shuffled):
    """A body, its turned and shuffled copy, and a sphere that is no body at all."""
    body = Bodies(n=1, topology="notoes_collapse5pc")[0]
    copy, _ = shuffled(body)
    turn = Rotation.from_rotvec([0.3, 2.0, -1.0]).as_matrix()
    from trimesh.creation import icosphere

    ball = icosphere(subdivisions=3)
    rough = ball.vertices * (1 + 0.3 * np.sin(3 * ball.vertices[:, :1]))
    return ShapeList([body, Mesh(copy.vertices @ turn.T, copy.faces), Mesh(rough, ball.faces)])


@pytest.fixture(scope="module")
def bases(collection):
    return [eigenbasis(mesh, 40) for mesh in collection]


@pytest.fixture(scope="module")
def maps(bases, collection):
    return AutoMaps(bases, collection)


def test_the_map_of_a_pair_is_that_of_match(maps, bases, collection):
    found = match(collection[0], collection[1], bases[0], bases[1])
    np.testing.assert_allclose(maps(0, 1), found.functional(bases[0], bases[1]), atol=1e-5)
    assert maps.quality(0, 1) == maps.quality(1, 0) == pytest.approx(found.quality)
    np.testing.assert_allclose(maps(1, 0) @ maps(0, 1), np.eye(40), atol=0.1)
    corners, weights = maps.points(0, 1)
    np.testing.assert_allclose(np.einsum("vc,vcx->vx", weights, collection[0].vertices[corners]),
                               found.carried(collection[0].vertices), atol=1e-5)  # fmt: skip
    assert len(maps.points(1, 0)[0]) == len(collection[0].vertices)


def test_maps_between_unlike_shapes_are_named(maps, caplog):
    with caplog.at_level(logging.WARNING):
        maps.prepare([(0, 1), (2, 0), (1, 2)], workers=1)
    assert maps.quality(0, 1) > 0.9
    assert maps.quality(0, 2) < 0.5
    assert "2 of 3 maps are not to be trusted" in caplog.text


def test_a_cache_keeps_all_of_it(maps, bases, collection, tmp_path, monkeypatch):
    C, kept = maps(0, 1), AutoMaps(bases, collection)
    kept.keep_in(Cache(tmp_path), lambda i, j, more: f"{i}_{j}")
    np.testing.assert_allclose(kept(0, 1), C, atol=1e-6)
    again = AutoMaps(bases, collection)
    again.keep_in(Cache(tmp_path), lambda i, j, more: f"{i}_{j}")
    monkeypatch.setattr(AutoMaps, "pair", None)
    np.testing.assert_allclose(again(1, 0), maps(1, 0), atol=1e-6)
    assert again.quality(0, 1) == pytest.approx(maps.quality(0, 1))


def test_clouds_are_matched_upright_and_that_is_told(collection, caplog):
    clouds = ShapeList([collection[0], PointCloud(collection[0].vertices)])
    maps = AutoMaps([eigenbasis(shape, 40) for shape in clouds], clouds)
    with caplog.at_level(logging.WARNING):
        maps.prepare([(0, 1)], workers=1)
    assert "clouds have no triangles" in caplog.text
    assert maps.quality(0, 1) is None
    assert maps(0, 1).shape == (40, 40)


def test_given_maps_come_first(bases, collection, monkeypatch):
    some = ShapeList(list(collection)[:2])
    some.vertex_maps = {(0, 1): np.zeros(615, dtype=int), (1, 0): np.arange(615)}
    maps = named_maps("auto")(bases[:2], some)
    monkeypatch.setattr(AutoMaps, "pair", None)
    maps.prepare([(0, 1)], workers=1)
    for pair in ((0, 1), (1, 0)):
        np.testing.assert_array_equal(maps(*pair), VertexMaps(bases[:2], some)(*pair))
        np.testing.assert_array_equal(maps.points(*pair)[0][:, 0], some.vertex_maps[pair])
    assert maps.quality(0, 1) is None


def test_of_a_map_given_one_way_the_other_is_computed(maps, bases, collection):
    some = ShapeList(list(collection)[:2])
    some.vertex_maps = {(0, 1): np.zeros(615, dtype=int)}
    half = AutoMaps(bases[:2], some)
    np.testing.assert_array_equal(half(0, 1), VertexMaps(bases[:2], some)(0, 1))
    np.testing.assert_array_equal(half(1, 0), maps(1, 0))


def test_the_truth_about_generated_shapes_is_not_looked_at(bases, collection):
    some = ShapeList(list(collection)[:2])
    some.vertex_maps, some.truth = {(0, 1): np.zeros(615, dtype=int), (1, 0): np.zeros(615, dtype=int)}, True
    assert AutoMaps(bases[:2], some).quality(0, 1) > 0.9
