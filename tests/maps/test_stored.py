"""Maps of pairs computed once, in advance or when asked for, in memory or in a cache."""

from functools import partial

import numpy as np
import pytest

from lssd_learn.collections import ShapeList
from lssd_learn.latent import MapNetwork
from lssd_learn.maps import AdjointMaps, ComputedMaps, KernelMatchingMaps, LandmarkMaps
from lssd_learn.maps.stored import STAGE, StoredMaps
from lssd_learn.pipeline import Pipeline
from lssd_learn.shapes import eigenbasis

ASKED = []


class Maker:
    """Says which pairs it was asked for; at module level, so that another process knows it."""

    def __init__(self, fails_at=None):
        self.fails_at = fails_at

    def pair(self, i, j):
        if (i, j) == self.fails_at:
            raise KeyboardInterrupt
        ASKED.append((i, j))
        return {"there": np.full(3, i), "back": np.full(2, j)}

    def depends_on(self, i, j):
        return ["nothing"]


@pytest.fixture(autouse=True)
def _anew():
    ASKED.clear()


@pytest.mark.parametrize("kept", [False, True])
def test_each_pair_is_computed_once(cache, kept):
    stored = StoredMaps(cache, lambda i, j, more: f"{i}-{j}-{more[0]}") if kept else StoredMaps()
    maker = Maker()
    stored.prepare(maker, [(0, 1), (0, 2)], workers=1)
    there, back = stored(maker, 0, 2)
    np.testing.assert_array_equal(there, [0, 0, 0])
    np.testing.assert_array_equal(back, [2, 2])
    stored(maker, 1, 2), stored(maker, 1, 2)
    stored.prepare(maker, [(0, 1), (1, 2), (1, 3)], workers=1)
    assert ASKED == [(0, 1), (0, 2), (1, 2), (1, 3)]
    assert cache.path(STAGE, "0-2-nothing").is_file() == kept


def test_a_killed_run_is_gone_on_with(cache):
    pairs = [(0, 1), (0, 2), (1, 2), (1, 3)]
    with pytest.raises(KeyboardInterrupt):
        StoredMaps(cache, lambda i, j, more: f"{i}-{j}").prepare(Maker(fails_at=(1, 2)), pairs, workers=1)
    assert pairs[:2] == ASKED
    StoredMaps(cache, lambda i, j, more: f"{i}-{j}").prepare(Maker(), pairs, workers=1)
    assert pairs == ASKED


def test_a_network_prepares_its_edges_and_no_more_and_finds_them_again(meshes, shuffled, cache, monkeypatch):
    asked = []
    compute = KernelMatchingMaps.vertex_maps
    monkeypatch.setattr(KernelMatchingMaps, "vertex_maps", lambda *a: asked.append(tuple(sorted(a[1:]))) or compute(*a))
    collection = ShapeList([shuffled(mesh, seed)[0] for seed, mesh in enumerate(meshes)])
    collection.key = "shuffled spheres"
    maps = partial(KernelMatchingMaps, samples=60, steps=2)

    def run(**more):
        arguments = {"k": 12, "size": 8, "keep": 6, "maps": maps, "network": MapNetwork.chain, "cache": cache}
        return Pipeline(collection, **{**arguments, **more}, workers=1).latent

    first = run()
    assert sorted(asked) == [(0, 1), (1, 2), (2, 3), (3, 4), (4, 5)]
    run(size=9)
    assert len(asked) == 5
    run(network=MapNetwork.star)
    assert sorted(asked[5:]) == [(0, 2), (0, 3), (0, 4), (0, 5)]
    run(maps=partial(maps, seed=1))
    assert len(asked) == 14
    monkeypatch.setattr(ComputedMaps, "version", ComputedMaps.version + 1)
    again = run()
    assert len(asked) == 19
    np.testing.assert_array_equal(first.Y, again.Y)


def test_maps_from_landmarks_depend_on_them(meshes):
    collection = ShapeList(meshes[:2])
    bases = [eigenbasis(mesh, 8) for mesh in collection]
    collection.landmarks = [{"a": 3, "b": 30, "c": 100, "d": 150}] * 2
    for kind in (LandmarkMaps, AdjointMaps):
        assert kind(bases, collection).depends_on(0, 1) == [[3, 30, 100, 150]] * 2
    assert KernelMatchingMaps(bases, collection).depends_on(0, 1) == []
