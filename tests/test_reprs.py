"""What objects say of themselves: a line, and what one wants to know."""

import numpy as np
import torch

from lssd_learn.collections import as_collection, eigenbases
from lssd_learn.collections.folder import UnrelatedMesh
from lssd_learn.latent import LatentSpace, MapNetwork, find_region
from lssd_learn.pipeline import Pipeline
from lssd_learn.shapes import PointCloud, eigenbasis


def test_everything_fits_a_line(meshes, cache):
    bases = [eigenbasis(mesh, 12) for mesh in meshes]
    network = MapNetwork.chain(bases)
    latent = LatentSpace.fit(network, 10, 7)
    told = {
        repr(meshes[0]): "Mesh(162 vertices, 320 faces)",
        repr(UnrelatedMesh(meshes[0].vertices, meshes[0].faces)): "UnrelatedMesh(162 vertices, 320 faces)",
        repr(PointCloud(np.zeros((2000, 3)))): "PointCloud(2,000 points)",
        repr(bases[0]): "Eigenbasis(12 functions on 162 vertices)",
        repr(as_collection(meshes)): "AtHand(6 shapes: 0, 1, …, 5)",
        repr(as_collection(meshes[:1])): "AtHand(1 shape: 0)",
        repr(as_collection([])): "AtHand(0 shapes)",
        repr(eigenbases(meshes, 5, cache=cache)): f"StoredBases(6 eigenbases in {cache.root})",
        repr(network): "MapNetwork(6 shapes of 12 functions, 5 edges, maps: vertex identity)",
        repr(MapNetwork.clique(bases)): "MapNetwork(6 shapes of 12 functions, clique, maps: vertex identity)",
        repr(latent): "LatentSpace(6 shapes of 12 functions, size=10, keep=7)",
        repr(latent.push(bases[0], {1: (np.eye(12), np.eye(12))})): "Pushed(12 functions, 7 latent)",
        repr(find_region(latent, np.ones(162, bool))): "Region(7 of 7 functions)",
        repr(Pipeline(meshes[:1], 9, size=9, keep=7)): "Pipeline(AtHand(1 shape: 0), VertexMaps, k=9, size=9, keep=7)",
        repr(cache): f"Cache('{cache.root}')",
    }  # fmt: skip
    for got, expected in told.items():
        assert got == expected


def test_a_pushed_shape_has_both_forms_and_conformal_is_the_one_that_nets_read(meshes):
    bases = [eigenbasis(mesh, 12) for mesh in meshes]
    latent = LatentSpace.fit(MapNetwork.clique(bases), 10, 7)
    eye = np.eye(12)
    pushed = latent.push(bases[2], {2: (eye, eye)})  # from itself
    for symmetric in (True, False):
        for ours, fitted in zip(pushed.differences(symmetric), latent.differences(symmetric), strict=True):
            torch.testing.assert_close(ours, fitted[2], rtol=0, atol=1e-9)
    torch.testing.assert_close(pushed.conformal, pushed.differences(symmetric=True)[1])
    torch.testing.assert_close(pushed.conformal, pushed.conformal.T)
