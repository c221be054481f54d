"""A latent space fitted to some of the shapes: the others are pushed into it."""

from dataclasses import replace
from functools import partial

import numpy as np
import torch

from lssd_learn.collections.eigenbases import eigenbases
from lssd_learn.latent import LatentSpace, MapNetwork
from lssd_learn.latent.newcomers import push_all
from lssd_learn.pipeline import Pipeline

SIZES = {"k": 16, "size": 12, "keep": 7}


def test_shapes_left_out_of_the_fit_are_pushed(spheres, cache):
    whole, some = (
        Pipeline(spheres(), **SIZES, cache=cache),
        Pipeline(spheres(), **SIZES, fitted=[0, 2, 3, 5], cache=cache),
    )
    latent = some.latent
    expected = LatentSpace.fit(MapNetwork.clique([whole.bases[i] for i in (0, 2, 3, 5)]), 12, 7)
    torch.testing.assert_close(latent.spectrum, expected.spectrum)
    torch.testing.assert_close(latent.Y[[0, 2, 3, 5]], expected.Y)
    pushed = push_all(expected, [whole.bases[i] for i in (1, 4)], ["1", "4"])
    torch.testing.assert_close(latent.Y[[1, 4]], pushed.Y)
    torch.testing.assert_close(latent.evals, whole.latent.evals)
    assert (len(latent), latent.names) == (6, tuple("012345"))
    np.testing.assert_array_equal(latent.bases[4].evecs, whole.bases[4].evecs)
    torch.testing.assert_close(Pipeline(spheres(), **SIZES, fitted=(0, 2, 3, 5), cache=None).latent.Y, latent.Y)
    assert len({p.keys["latent"] for p in (whole, some, replace(some, fitted=(0, 2, 3)))}) == 3


def test_a_fit_to_some_keeps_their_labels(spheres, cache):
    collection = spheres()
    collection.groups = {"side": list("aabbab")}
    network = partial(MapNetwork.clusters, labels="side")
    latent = Pipeline(collection, **SIZES, network=network, fitted=[0, 1, 2, 4, 5], cache=cache).latent
    bases = eigenbases(collection, 16, cache=cache)
    expected = MapNetwork.clusters([bases[i] for i in (0, 1, 2, 4, 5)], labels=list("aabab"))
    torch.testing.assert_close(latent.spectrum, LatentSpace.fit(expected, 12, 7).spectrum)
