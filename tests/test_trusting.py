"""A run with computed maps: what is not to be trusted is left out, named, and shown."""

import csv
import logging
from types import SimpleNamespace

import numpy as np
import pytest
import trimesh
from PIL import Image

from lssd_learn.collections import Bodies, ShapeList
from lssd_learn.latent import MapNetwork
from lssd_learn.mapped import PICTURE, TABLE, leave_qualities
from lssd_learn.maps import AutoMaps
from lssd_learn.pipeline import Pipeline
from lssd_learn.shapes import Mesh, eigenbasis
from lssd_learn.trusting import quality_rows, trusted_network


@pytest.fixture(scope="module")
def bases():
    return [eigenbasis(body, 30) for body in Bodies(n=4, topology="notoes_collapse5pc")]


def maps_of(qualities):
    return SimpleNamespace(quality=lambda i, j: qualities.get((i, j)), level=0.5, unreached=lambda i, j: None)


def test_bad_edges_go_and_who_hangs_on_one_is_named(bases, caplog):
    network = MapNetwork.clique(bases, weights=[1.0, 2.0, 3.0, 4.0])
    maps = maps_of({(0, 1): 0.9, (0, 2): 0.8, (1, 2): 0.4, (0, 3): 0.1, (1, 3): 0.3, (2, 3): 0.2})
    with caplog.at_level(logging.INFO):
        kept = trusted_network(network, maps, ["a", "b", "c", "d"])
    assert kept.pairs().tolist() == [[0, 1], [0, 2], [1, 3]]
    np.testing.assert_array_equal(kept.weights, [2.0, 3.0, 8.0])
    assert "joins 1 of 4 shapes to the others: d" in caplog.text
    assert "3 of 6 are left out" in caplog.text
    rows = quality_rows(network, maps, ["a", "b", "c", "d"])
    assert [(row["source"], row["target"], row["trusted"]) for row in rows[:2]] == [("a", "d", 0), ("c", "d", 0)]


def test_a_shape_that_most_maps_fail_at_is_named_though_one_is_good(bases, caplog):
    maps = maps_of({(0, 1): 0.9, (0, 2): 0.8, (1, 2): 0.9, (0, 3): 0.7, (1, 3): 0.3, (2, 3): 0.2})
    kept = trusted_network(MapNetwork.clique(bases), maps, list("abcd"))
    assert [0, 3] in kept.pairs().tolist()
    assert caplog.messages == ["maps: of 1 of 4 shapes most maps to the others are not to be trusted: d"]


def test_a_network_of_good_maps_stays_what_it_is(bases):
    network = MapNetwork.clique(bases)
    assert trusted_network(network, maps_of({}), list("abcd")) is network
    assert quality_rows(network, maps_of({}), list("abcd")) == []


def test_a_stranger_is_left_out_and_shown(tmp_path, caplog):
    body = Bodies(n=1, topology="notoes_collapse5pc")[0]
    ring = trimesh.creation.torus(1, 0.3, major_sections=24, minor_sections=12)
    copy = Mesh(body.vertices, body.faces[::-1])  # the same faces in another order: no common connectivity
    shapes = ShapeList([body, copy, Mesh(ring.vertices, ring.faces)])
    pipeline = Pipeline(shapes, 40, maps=AutoMaps, size=30, keep=20, cache=None, workers=1)
    leave_qualities(pipeline, tmp_path)
    assert not list(tmp_path.iterdir())  # no maps were asked for
    with caplog.at_level(logging.INFO):
        _ = pipeline.latent
        leave_qualities(pipeline, tmp_path)
    assert "joins 1 of 3 shapes to the others: 2" in caplog.text
    with (tmp_path / TABLE).open() as file:
        rows = list(csv.DictReader(file))
    assert [row["trusted"] for row in rows] == ["0", "0", "1"]
    assert {rows[2]["source"], rows[2]["target"]} == {"0", "1"}
    picture = np.asarray(Image.open(tmp_path / PICTURE).convert("RGB"), dtype=int)
    coloured = (picture.max(axis=2) - picture.min(axis=2)) > 60
    assert coloured.mean() > 0.05  # three rows of shapes in colours


def test_a_body_without_a_leg_is_named(tmp_path, caplog):
    bodies = Bodies(n=2, topology="notoes_collapse5pc")
    mesh = bodies[1]
    middles = mesh.vertices[mesh.faces].mean(axis=1)
    low = middles[:, 2] < np.quantile(middles[:, 2], 0.3)
    legless = pruned(mesh, ~low | (middles[:, 0] > 0))
    assert 0.1 < 1 - legless.area / mesh.area < 0.33
    shapes = ShapeList([bodies[0], Mesh(mesh.vertices, mesh.faces[::-1]), legless])
    shapes.names = ["one", "two", "legless"]
    pipeline = Pipeline(shapes, 40, maps=AutoMaps, size=30, keep=20, cache=None, workers=1)
    _ = pipeline.latent
    assert "1 of 3 shapes seem to lack a part that the others have, or to be of another kind: legless" in caplog.text
    rows = {row["source"] + row["target"]: row for row in pipeline.map_qualities()}
    assert rows["onelegless"]["source_unreached"] > 2 * rows["onelegless"]["target_unreached"]
    assert rows["onetwo"]["source_unreached"] < 0.01


def pruned(mesh, faces):
    """The part of a mesh that some of its faces are."""
    used, numbers = np.unique(mesh.faces[faces], return_inverse=True)
    return Mesh(mesh.vertices[used], numbers.reshape(-1, 3))
