import pickle

import numpy as np
import pytest
from hydra import compose, initialize_config_dir
from hydra.utils import instantiate

from lssd_learn.app import conf
from lssd_learn.collections import Bodies, Remeshed, ShapeList
from lssd_learn.errors import InputError
from lssd_learn.maps import VertexMaps, euclidean_errors
from lssd_learn.pipeline import Pipeline
from lssd_learn.shapes import Mesh, PointCloud, eigenbasis
from lssd_learn.shapes.edges import edge_lengths, edges


@pytest.fixture(scope="module")
def bodies():
    return Bodies(n=4, topology="notoes_collapse10pc")


@pytest.fixture(scope="module")
def remeshed(bodies):
    return Remeshed(bodies, vertices=(700, 900))


@pytest.fixture(scope="module")
def scanned(bodies):
    return Remeshed(bodies, "cloud", (2000, 2000))


def test_every_shape_has_a_mesh_of_its_own_and_what_is_known_of_its_body(bodies, remeshed):
    assert len(remeshed) == 4
    assert len({mesh.connectivity for mesh in remeshed}) == 4
    assert all(700 <= len(mesh.vertices) <= 900 for mesh in remeshed)
    assert (remeshed.names, remeshed.up) == (bodies.names, "z")
    np.testing.assert_array_equal(remeshed.parameters, bodies.parameters)
    assert remeshed.groups["pose"].tolist() == bodies.groups["pose"].tolist()


def test_clouds_lie_on_the_body(bodies, scanned):
    cloud = scanned[1]
    assert isinstance(cloud, PointCloud)
    assert len(cloud.points) == 2000
    away = np.linalg.norm(cloud.points - bodies[1].vertices[scanned.origins(1)], axis=1)
    assert away.mean() < 0.04
    assert eigenbasis(cloud, 5).area == pytest.approx(bodies[1].area, rel=0.1)


def test_heads_of_the_configuration_have_meshes_of_their_own():
    with initialize_config_dir(str(conf()), version_base="1.3"):
        heads = instantiate(compose("config", ["collection=remeshed_faces"]).collection)
    assert len(heads) == 40
    assert 2500 <= len(heads[3].vertices) <= 4000


@pytest.mark.parametrize("kind", ["remeshed", "scanned"])
def test_true_maps_lead_to_the_same_place_of_the_body(bodies, kind, request):
    shapes = request.getfixturevalue(kind)
    found = shapes.vertex_maps[2, 3]
    assert found.shape == (len(shapes[3].vertices),)
    assert found.max() < len(shapes[2].vertices)
    # Seen on body 2: where the vertices of 3 come from, and where they are sent to.
    assert euclidean_errors(bodies[2], shapes.origins(2)[found], shapes.origins(3)).mean() < 0.03
    assert len(shapes.vertex_maps) == len(list(shapes.vertex_maps)) == 12
    assert (1, 1) not in shapes.vertex_maps
    with pytest.raises(KeyError):
        shapes.vertex_maps[0, 4]


def test_a_mesh_may_be_finer_than_the_body(bodies):
    fine = Remeshed(bodies, vertices=(2000, 2000))
    mesh, body = fine[2], bodies[2]
    assert len(mesh.vertices) == 2000
    assert mesh.area == pytest.approx(body.area, rel=0.04)
    long = edge_lengths(body.vertices, edges(body.faces)).max()
    assert np.linalg.norm(mesh.vertices - body.vertices[fine.origins(2)], axis=1).max() < long
    assert euclidean_errors(body, fine.origins(2)[fine.vertex_maps[2, 3]], fine.origins(3)).mean() < 0.02


def test_the_way_back_is_the_way(remeshed):
    np.testing.assert_array_equal(remeshed.nearest(0)[remeshed.origins(0)], np.arange(len(remeshed[0].vertices)))


def test_operators_by_the_true_maps_are_those_of_the_bodies(bodies, remeshed):
    sizes = {"k": 40, "size": 24, "keep": 10, "cache": None, "workers": 1}
    ours, theirs = (Pipeline(c, maps=VertexMaps, **sizes).operators()[:, 0] for c in (remeshed, bodies))
    spectra = [np.linalg.eigvalsh(operators.numpy()) for operators in (ours, theirs)]
    assert np.linalg.norm(spectra[0] - spectra[1]) < 0.2 * np.linalg.norm(spectra[1] - 1)


@pytest.mark.parametrize("kind", ["mesh", "cloud"])
def test_turned_shapes_are_the_same_but_for_a_rotation(bodies, kind):
    arguments = {"kind": kind, "vertices": (700, 900)}
    plain, about, anyhow = (Remeshed(bodies, **arguments, turned=how) for how in ("none", "vertical", "any"))
    assert len({plain.key, about.key, anyhow.key}) == 3
    assert (plain.up, about.up, anyhow.up) == ("z", "z", None)
    for shapes in (about, anyhow):
        np.testing.assert_array_equal(shapes.vertex_maps[0, 1], plain.vertex_maps[0, 1])
        turn = np.linalg.lstsq(plain[2].vertices, shapes[2].vertices)[0]
        np.testing.assert_allclose(plain[2].vertices @ turn, shapes[2].vertices, atol=1e-9)
        np.testing.assert_allclose(turn.T @ turn, np.eye(3), atol=1e-9)
        assert np.linalg.det(turn) == pytest.approx(1)
        assert not np.allclose(turn, np.linalg.lstsq(plain[1].vertices, shapes[1].vertices)[0], atol=0.1)
    np.testing.assert_allclose(about[2].vertices[:, 2], plain[2].vertices[:, 2], atol=1e-12)
    assert not np.allclose(anyhow[2].vertices[:, 2], plain[2].vertices[:, 2])


def test_landmarks_are_the_same_places(bodies):
    shapes = Remeshed(bodies, vertices=(700, 900), marks=6)
    assert [len(marks) for marks in shapes.landmarks] == [6] * 4
    places = [shapes.origins(i)[list(marks.values())] for i, marks in enumerate(shapes.landmarks)]
    assert euclidean_errors(bodies[0], places[1], places[0]).max() < 0.08
    assert not Remeshed(bodies, vertices=(700, 900)).landmarks


def test_keys_and_processes(bodies, remeshed):
    longer = Remeshed(Bodies(n=5, topology="notoes_collapse10pc"), vertices=(700, 900))
    assert longer.shape_key(3) == remeshed.shape_key(3) != remeshed.shape_key(2)
    assert longer.key != remeshed.key
    others = [
        Remeshed(bodies),
        Remeshed(bodies, "cloud", (700, 900)),
        Remeshed(bodies, vertices=(700, 900), seed=1),
        Remeshed(bodies, vertices=(700, 900), marks=3),
    ]
    assert len({remeshed.key, *(other.key for other in others)}) == 5
    assert others[3].shape_key(0) == remeshed.shape_key(0)
    copy = pickle.loads(pickle.dumps(remeshed))
    np.testing.assert_array_equal(copy[1].vertices, remeshed[1].vertices)
    assert copy.vertex_maps[0, 1].shape == remeshed.vertex_maps[0, 1].shape
    plain = Remeshed(ShapeList([bodies[0], bodies[1]]), vertices=(700, 700))
    assert (plain.key, plain.shape_key(0)) == (None, None)
    assert plain[1].connectivity == plain[1].connectivity


def test_the_configuration():
    with initialize_config_dir(str(conf()), version_base="1.3"):
        cfg = compose("config", overrides=["collection=remeshed", "collection.base.seed=1", "collection.kind=cloud"])
    shapes = instantiate(cfg.collection)
    assert (len(shapes), shapes.base.seed, shapes.kind, shapes.vertices) == (60, 1, "cloud", (5000, 8000))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"kind": "scan"}, "collection.kind=scan: expected one of mesh, cloud"),
        ({"vertices": [5]}, r"collection.vertices=\[5\]: expected two numbers"),
        ({"vertices": [900, 700]}, "collection.vertices=700: expected a whole number, 900 or more"),
        ({"seed": -1}, "collection.seed=-1: expected a whole number, 0 or more"),
        ({"marks": -1}, "collection.marks=-1: expected"),
        ({"turned": "over"}, "collection.turned=over: expected one of none, vertical, any"),
    ],
)
def test_numbers_out_of_range_are_refused(bodies, arguments, message):
    with pytest.raises(InputError, match=message):
        Remeshed(bodies, **arguments)


def test_what_cannot_be_remeshed_is_named(bodies):
    with pytest.raises(InputError, match=r"collection.vertices=\[5000, 5000\]: expected at most 4910, those of body_0"):
        Remeshed(bodies, vertices=(5000, 5000))[0]
    with pytest.raises(InputError, match="0: expected a mesh to remesh, got a cloud"):
        Remeshed(ShapeList([PointCloud(np.random.default_rng(0).normal(size=(50, 3)))]))[0]
    with pytest.raises(IndexError):
        Remeshed(bodies)[4]
    assert isinstance(Remeshed(bodies, vertices=(700, 900))[-1], Mesh)
