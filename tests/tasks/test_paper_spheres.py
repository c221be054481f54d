"""The paper's four spheres: what is found lies on the bump it should lie on."""

import numpy as np
import pytest

from lssd_learn.collections import Bumps
from lssd_learn.exploration import cross_collection, evidence, global_variability, local_evidence
from lssd_learn.exploration.scores import area_under_curve, strongest
from lssd_learn.latent import LatentSpace, MapNetwork
from lssd_learn.shapes import eigenbasis


@pytest.fixture(scope="module")
def spheres():
    """The settings of `experiment=paper_spheres`: latent space, area operators, and where either bump changes areas."""
    bases = [eigenbasis(mesh, 80) for mesh in Bumps()]
    latent = LatentSpace.fit(MapNetwork.clique(bases), 64, 40)
    plain, side, top, _ = (np.log(basis.mass) for basis in bases)
    return latent, latent.differences()[0], {"side": strongest(side - plain), "top": strongest(top - plain)}


@pytest.mark.parametrize("i", range(4))
def test_each_function_sits_on_its_bump(spheres, i):
    latent, D, bumps = spheres
    groups = list("AABB")
    across, all_pairs = latent.to_shape(cross_collection(D, groups), i), latent.to_shape(global_variability(D), i)
    region = local_evidence(latent, evidence(D, groups), i)
    scores = [
        area_under_curve(field, bumps[name])
        for field, name in ((across.square(), "top"), (region, "top"), (all_pairs.square(), "side"))
    ]
    assert min(scores) > 0.995
    assert area_under_curve(across.square(), bumps["side"]) < 0.6
    assert area_under_curve(all_pairs.square(), bumps["top"]) < 0.6
