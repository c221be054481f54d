"""The whole way from shapes to operators, and what the cache spares."""

import logging
import shutil
from functools import partial

import numpy as np
import pytest
import torch

from lssd_learn.cache import Cache
from lssd_learn.collections import Folder
from lssd_learn.collections.base import ShapeList
from lssd_learn.collections.clouds import clouds
from lssd_learn.collections.eigenbases import StoredBases
from lssd_learn.collections.previews import previews
from lssd_learn.errors import InputError
from lssd_learn.latent import LatentSpace, MapNetwork
from lssd_learn.maps import RegistrationMaps
from lssd_learn.pipeline import Pipeline
from lssd_learn.shapes import Mesh, PointCloud

SIZES = {"k": 16, "size": 12, "keep": 7}


class Untouched(ShapeList):
    """A collection that knows everything but its shapes."""

    def __getitem__(self, i):
        raise AssertionError(f"shape {i} was asked for")

    def check(self):
        raise AssertionError("the shapes were checked")


def entries(cache, stage):
    return sorted(file.stem for file in (cache.root / stage).glob("*/*.arrays"))


def test_the_stages_are_what_they_say(spheres, meshes, cache):
    pipeline = Pipeline(spheres(), **SIZES, cache=cache)
    assert len(pipeline.bases) == 6
    latent = pipeline.latent
    expected = LatentSpace.fit(MapNetwork.clique(pipeline.bases), 12, 7)
    torch.testing.assert_close(latent.Y, expected.Y)
    assert latent.keep == 7
    assert latent.energy.shape == (12,)
    assert latent.names == tuple("012345")
    assert latent.to_shape(np.ones(7), 3).shape == (len(meshes[3].vertices),)


def test_operators_are_channels(spheres, cache):
    pipeline = Pipeline(spheres(), **SIZES, cache=cache)
    area, conformal = pipeline.latent.differences(symmetric=True)
    assert torch.equal(pipeline.operators(), area[:, None])
    assert torch.equal(pipeline.operators(["conformal"]), conformal[:, None])
    both = pipeline.operators(("conformal", "area"))
    assert (both.shape, both.dtype) == ((6, 2, 7, 7), torch.float64)
    assert torch.equal(both[:, 0], conformal)
    assert torch.equal(both[:, 1], area)
    for kinds in ((), ("area", "volume")):
        with pytest.raises(InputError, match=r"latent.operators=.*: expected some of area, conformal"):
            pipeline.operators(kinds)


def test_a_second_run_reads_everything_and_touches_no_shape(spheres, cache):
    first = Pipeline(spheres(), **SIZES, cache=cache)
    expected = first.operators(("area", "conformal")), first.clouds(50, seed=3), first.latent.to_shape(np.ones(7), 2)
    second = Pipeline(spheres(Untouched), **SIZES, cache=Cache(cache.root))
    assert torch.equal(second.operators(("area", "conformal")), expected[0])
    np.testing.assert_array_equal(second.clouds(50, seed=3), expected[1])
    assert torch.equal(second.latent.to_shape(np.ones(7), 2), expected[2])
    np.testing.assert_array_equal(second.bases[4].evecs, first.bases[4].evecs)


def test_a_cached_latent_space_opens_no_eigenbasis(spheres, cache, monkeypatch):
    Pipeline(spheres(), **SIZES, cache=cache).operators()

    def opened(*_):
        raise AssertionError("an eigenbasis was opened")

    monkeypatch.setattr(StoredBases, "__getitem__", opened)
    assert Pipeline(spheres(Untouched), **SIZES, cache=cache).operators().shape == (6, 1, 7, 7)


def test_keep_shares_everything(spheres, cache):
    wide = Pipeline(spheres(), **SIZES, cache=cache)
    wide.operators()
    narrow = wide.with_keep(4)
    assert narrow.keys == wide.keys
    again = Pipeline(spheres(Untouched), **(SIZES | {"keep": 4}), cache=cache)
    for pipeline in (narrow, again):
        torch.testing.assert_close(pipeline.operators(), wide.operators()[..., :4, :4], rtol=0, atol=1e-14)
    assert len(entries(cache, "latent")) == 1


def test_everything_that_changes_the_result_changes_the_key(spheres, meshes):
    def key(shapes=None, **changes):
        return Pipeline(shapes or spheres(), **(SIZES | changes)).keys["latent"]

    def with_maps(which):
        shapes = spheres(key=which)
        shapes.vertex_maps = {(0, 1): np.arange(len(meshes[0].vertices))}
        return shapes

    keys = {
        "plain": key(),
        "k": key(k=17),
        "size": key(size=11),
        "laplacian": key(laplacian="robust"),
        "collection": key(spheres(key="others")),
        "chain": key(network=MapNetwork.chain),
        "nearest": key(network=partial(MapNetwork.nearest, neighbours=2)),
        "more": key(network=partial(MapNetwork.nearest, neighbours=3)),
        "unit area": key(network=partial(MapNetwork.nearest, neighbours=3, unit_area=True)),
        "half": key(network=partial(MapNetwork.clusters, labels="half")),
        "parity": key(network=partial(MapNetwork.clusters, labels="parity")),
        "weights": key(network=partial(MapNetwork.clique, weights=[1, 1, 1, 1, 1, 2])),
        "other weights": key(network=partial(MapNetwork.clique, weights=[1, 1, 1, 1, 1, 3])),
        "maps": key(with_maps("spheres")),
    }
    assert len(set(keys.values())) == len(keys)
    relabelled = spheres()
    relabelled.groups = {"half": np.array(list("aabbbb"))}
    assert key(relabelled, network=partial(MapNetwork.clusters, labels="half")) != keys["half"]
    assert key() == keys["plain"]
    assert key(workers=3, remedy="lssd", keep=2) == keys["plain"]


def test_the_seed_and_the_number_of_points_are_in_the_key_of_clouds(spheres):
    assert len({Pipeline(spheres(), **SIZES).clouds_key(*a) for a in ((40, 5), (40, 6), (41, 5))}) == 3


def test_eigenbases_are_shared_by_all_networks_and_sizes(spheres, cache):
    for changes in ({}, {"size": 10}, {"network": MapNetwork.chain}):
        Pipeline(spheres(), **(SIZES | changes), cache=cache).operators()
    assert len(entries(cache, "eigenbasis")) == 6
    assert len(entries(cache, "latent")) == 3


def test_arrays_and_lists_of_edges_are_one_key(spheres, cache):
    edges = [[0, 1], [1, 2], [2, 3], [3, 4], [4, 5]]
    made = [
        Pipeline(spheres(), **SIZES, cache=cache, network=partial(MapNetwork.from_edges, edges=which))
        for which in (edges, np.array(edges), tuple(map(tuple, edges)))
    ]
    assert len({pipeline.keys["latent"] for pipeline in made}) == 1
    chain = Pipeline(spheres(), **SIZES, cache=cache, network=MapNetwork.chain)
    torch.testing.assert_close(made[1].operators(), chain.operators())


def test_edges_from_a_config_work(spheres, cache):
    hydra = pytest.importorskip("hydra")
    node = {"_target_": "lssd_learn.latent.MapNetwork.from_edges", "_partial_": True, "edges": [[0, 1], [2, 0]]}
    network = hydra.utils.instantiate(node)
    three = ShapeList(list(spheres())[:3])
    three.key = "three"
    assert Pipeline(three, **SIZES, cache=cache, network=network).operators().shape == (3, 1, 7, 7)


def test_a_network_without_a_name_is_not_cached_under_the_name_of_another(spheres, cache):
    def local(bases, maps):
        return MapNetwork.chain(bases, maps)

    for nameless in (lambda bases, maps: MapNetwork.chain(bases, maps), local):
        with pytest.raises(InputError, match="network: expected a function with a name or a partial of one"):
            Pipeline(spheres(), **SIZES, cache=cache, network=nameless).operators()
        free = Pipeline(spheres(), **SIZES, cache=None, network=nameless)
        chain = Pipeline(spheres(), **SIZES, cache=cache, network=MapNetwork.chain)
        assert torch.equal(free.operators(), chain.operators())


def test_labels_name_a_group(spheres, cache):
    pipeline = Pipeline(spheres(), **SIZES, cache=cache, network=partial(MapNetwork.clusters, labels="half"))
    expected = LatentSpace.fit(MapNetwork.clusters(pipeline.bases, "aaabbb"), 12, 7)
    torch.testing.assert_close(pipeline.latent.Y, expected.Y)
    given = Pipeline(spheres(), **SIZES, cache=cache, network=partial(MapNetwork.clusters, labels=list("aaabbb")))
    assert torch.equal(given.latent.Y, pipeline.latent.Y)
    with pytest.raises(
        InputError, match="network.labels=colour: expected a group of the collection; it has half, parity"
    ):
        Pipeline(spheres(), **SIZES, cache=cache, network=partial(MapNetwork.clusters, labels="colour")).operators()


def test_a_plain_list_is_kept_by_what_it_holds(spheres, meshes, cache):
    expected = Pipeline(spheres(), **SIZES, cache=None).operators()
    torch.testing.assert_close(Pipeline(meshes, **SIZES, cache=cache).operators(), expected)
    made = entries(cache, "latent"), entries(cache, "eigenbasis")
    again = Pipeline(list(meshes), **SIZES, cache=cache)
    assert torch.equal(again.operators(), Pipeline(meshes, **SIZES, cache=cache).operators())
    assert (entries(cache, "latent"), entries(cache, "eigenbasis")) == made


@pytest.mark.parametrize("kind", ["no key", "no cache"])
def test_without_a_key_or_a_cache_it_works_and_keeps_nothing(spheres, meshes, cache, kind):
    shapes = spheres(key=None if kind == "no key" else "spheres")
    pipeline = Pipeline(shapes, **SIZES, cache=None if kind == "no cache" else cache)
    expected = Pipeline(spheres(), **SIZES, cache=Cache(cache.root.with_name("other")))
    assert torch.equal(pipeline.operators(), expected.operators())
    np.testing.assert_array_equal(pipeline.clouds(20), expected.clouds(20))
    assert pipeline.latent.to_shape(np.ones(7), 0).shape == (162,)
    assert (pipeline.keys == {}) == (kind != "no cache")
    assert not cache.root.exists()
    assert len(clouds(meshes, 20, cache=None)) == len(previews(meshes, 9, cache=None)) == 6


def test_shapes_that_are_not_in_correspondence_go_by_their_maps(meshes, cache):
    """One shape with its vertices in another order, and the map that undoes it."""
    order = np.random.default_rng(0).permutation(162)
    back = np.argsort(order)
    shuffled = Mesh(meshes[2].vertices[order], back[meshes[2].faces])
    mixed = ShapeList([*meshes[:2], shuffled, *meshes[3:]])
    mixed.key = "mixed"
    mixed.vertex_maps = {(0, 2): order, (2, 1): back}
    plain = ShapeList(meshes)
    area, expected = (Pipeline(shapes, **SIZES, cache=cache).operators() for shapes in (mixed, plain))
    torch.testing.assert_close(torch.linalg.eigvalsh(area), torch.linalg.eigvalsh(expected), rtol=0, atol=1e-4)
    mixed.vertex_maps, mixed.key = {(0, 2): order}, "mixed one way"
    with pytest.raises(InputError, match="maps: 2 and 0 are not in vertex correspondence"):
        Pipeline(mixed, **SIZES, cache=cache).operators()


def test_point_clouds_are_not_taken_to_be_in_correspondence_even_from_the_cache(meshes, cache):
    points = ShapeList([PointCloud(mesh.vertices) for mesh in meshes])
    points.key = "clouds"
    pipeline = Pipeline(points, **SIZES, cache=cache)
    assert pipeline.bases[0].connectivity is None
    with pytest.raises(InputError, match="maps=correspondence: 0 and 1 are not in vertex correspondence"):
        pipeline.operators()


def test_a_damaged_eigenbasis_is_made_again(spheres, cache, caplog):
    expected = Pipeline(spheres(), **SIZES, cache=cache).bases[2].evecs.copy()
    file = cache.path("eigenbasis", entries(cache, "eigenbasis")[2])
    file.write_bytes(b"?" + file.read_bytes()[1:])
    with caplog.at_level(logging.WARNING):
        again = Pipeline(spheres(), **SIZES, cache=Cache(cache.root)).bases
    assert "is damaged" in caplog.text
    np.testing.assert_array_equal(again[2].evecs, expected)


def test_a_missing_eigenbasis_names_the_remedy(spheres, cache):
    Pipeline(spheres(), **SIZES, cache=cache).operators()
    shutil.rmtree(cache.root / "eigenbasis")
    pipeline = Pipeline(spheres(Untouched), **SIZES, cache=cache, remedy="lssd task=operators")
    pipeline.operators()
    with pytest.raises(InputError, match="is missing; make it again with: lssd task=operators"):
        pipeline.latent.to_shape(np.ones(7), 0)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"k": 0}, "basis.k=0: expected a whole number, 1 or more"),
        ({"workers": 0}, "parallel.workers=0: expected a whole number, 1 or more"),
        ({"size": 17}, "latent.size=17: expected 1 to k=16"),
        ({"size": 0}, "latent.size=0: expected 1 to k=16"),
        ({"keep": 13}, "latent.keep=13: expected 1 to size=12"),
        ({"keep": 0}, "latent.keep=0: expected 1 to size=12"),
    ],
)
def test_sizes_are_checked_before_any_work(spheres, changes, message):
    with pytest.raises(InputError, match=message):
        Pipeline(spheres(Untouched), **(SIZES | changes))


def test_one_shape_is_no_collection(meshes):
    with pytest.raises(InputError, match="collection: expected 2 shapes or more, got 1"):
        _ = Pipeline(meshes[:1], **SIZES).latent


def test_a_table_that_changes_is_checked_although_everything_is_cached(small_mesh_folder, cache):
    Pipeline(Folder(small_mesh_folder), **SIZES, cache=cache).operators()
    (small_mesh_folder / "landmarks.csv").write_text("name,landmark,vertex\nshape_0,nose,162\n")
    with pytest.raises(InputError, match=r"landmarks.csv, line 2: expected a vertex of shape_0.ply, 0 to 161, got 162"):
        Pipeline(Folder(small_mesh_folder), **SIZES, cache=cache).operators()
    assert len(entries(cache, "checked")) == 1


def test_a_shape_that_cannot_be_used_is_named(meshes, cache):
    small = Mesh(np.eye(4)[:, :3], [[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]])
    with pytest.raises(InputError, match="^1: k: expected 1 to 3, fewer than the shape's 4 vertices, got 16"):
        Pipeline([meshes[0], small], **SIZES, maps=RegistrationMaps, cache=cache).operators()


def test_the_latent_space_is_computed_on_the_device_asked_for(meshes, monkeypatch):
    """No other device is at hand where tests run: what `fit` is told is looked at."""
    asked = []
    fit = LatentSpace.fit.__func__
    watched = classmethod(lambda cls, *args, **options: asked.append(options["device"]) or fit(cls, *args, **options))
    monkeypatch.setattr(LatentSpace, "fit", watched)
    for device in ("cpu", "cpu:0"):
        assert Pipeline(meshes, **SIZES, cache=None, device=device).latent.Y.device.type == "cpu"
    assert asked == ["cpu", "cpu:0"]
