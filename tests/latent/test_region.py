"""A region of the shapes as functions on the latent shape."""

from dataclasses import replace

import numpy as np
import pytest
import torch

from lssd_learn.collections import Bodies
from lssd_learn.errors import InputError
from lssd_learn.latent import LatentSpace, MapNetwork, find_region

PARTS = ["head", "torso", "left_leg", "upper_body"]


@pytest.fixture(scope="module")
def parts():
    return Bodies(n=1, topology="notoes_collapse5pc").parts


@pytest.fixture(scope="module")
def latent(many_bodies):
    return LatentSpace.fit(MapNetwork.clique(many_bodies[:8]), 64, 40)


def eye(m):
    return torch.eye(m, dtype=torch.float64)


def close(actual, expected, atol=1e-9):
    torch.testing.assert_close(actual, expected, rtol=0, atol=atol)


@pytest.mark.parametrize("part", PARTS)
def test_shares_lie_between_0_and_1_and_F_is_orthonormal(latent, parts, part):
    found = find_region(latent, parts[part])
    assert found.shares.min() > -1e-9
    assert found.shares.max() < 1 + 1e-9
    assert (found.shares.diff() <= 0).all()
    F = found.functions
    assert F.shape == (40, int((found.shares > 0.5).sum()))
    assert 0 < F.shape[1] < 40
    close(F.T @ F, eye(F.shape[1]))
    close(F.T @ found.operator @ F, torch.diag(found.shares[: F.shape[1]]))
    close(latent.region(parts[part]), F)


@pytest.mark.parametrize("part", PARTS)
def test_a_region_and_its_complement_part_the_functions(latent, parts, part):
    inside, outside = find_region(latent, parts[part]), find_region(latent, ~parts[part])
    close(inside.operator + outside.operator, eye(40))
    F, G = inside.functions, outside.functions
    assert F.shape[1] + G.shape[1] == 40
    close(F @ F.T + G @ G.T, eye(40), atol=1e-8)


def test_everything_is_the_identity_and_nothing_is_zero(latent):
    everything, nothing = (find_region(latent, np.full(615, value)) for value in (True, False))
    close(everything.operator, eye(40))
    assert everything.functions.shape == (40, 40)
    assert float(nothing.operator.abs().max()) == 0
    assert nothing.functions.shape == (40, 0)


def test_the_constant_has_the_regions_part_of_the_area(latent, parts):
    """Its share is the mean over the shapes of what they have there, all shapes' areas being counted as one."""
    area = np.array([[basis.mass[parts["torso"]].sum(), basis.mass.sum()] for basis in latent.bases])
    expected = area[:, 0].sum() / area[:, 1].sum()
    assert float(find_region(latent, parts["torso"]).operator[0, 0]) == pytest.approx(expected, rel=1e-2)


@pytest.mark.parametrize("part", PARTS)
def test_functions_of_a_part_live_there_on_every_shape(latent, parts, part):
    F = latent.region(parts[part])
    for i in (0, 3):
        values, M = latent.to_shape(F[:, :2], i).numpy(), latent.bases[i].mass
        inside = (M[:, None] * values**2)[parts[part]].sum(0) / (M[:, None] * values**2).sum(0)
        assert (inside > 0.85).all()


def test_a_higher_threshold_keeps_the_first_functions_only(latent, parts):
    found = find_region(latent, parts["torso"], 0.9)
    r = found.functions.shape[1]
    assert 0 < r < latent.region(parts["torso"]).shape[1]
    assert found.shares[r - 1] > 0.9 >= found.shares[r]
    close(found.functions, latent.region(parts["torso"])[:, :r])


def test_a_mask_a_shape_is_the_mask_of_all(latent, parts):
    shared = find_region(latent, parts["head"]).operator
    close(find_region(latent, [parts["head"]] * 8).operator, shared)
    close(find_region(latent, np.stack([parts["head"]] * 8)).operator, shared)
    close(find_region(latent, torch.from_numpy(parts["head"])).operator, shared)
    alone = [parts["head"] if i == 2 else np.zeros(615, dtype=bool) for i in range(8)]
    Phi = latent.bases[2].evecs[parts["head"]] @ latent.basis(2).numpy()
    expected = Phi.T @ (latent.bases[2].mass[parts["head"], None] * Phi) / 8
    np.testing.assert_allclose(find_region(latent, alone).operator, expected, atol=1e-12)


def test_borders(latent, parts):
    head = parts["head"]
    with pytest.raises(InputError, match="masks: expected one for all shapes or one for each of 8, got 3"):
        find_region(latent, [head] * 3)
    with pytest.raises(
        InputError, match=r"masks: expected a bool for each of the 615 vertices of shape 0, got bool \(9,"
    ):
        find_region(latent, head[:9])
    with pytest.raises(InputError, match="got int64"):
        find_region(latent, np.flatnonzero(head))
    with pytest.raises(InputError, match="masks: expected one for all shapes"):
        find_region(latent, [])
    with pytest.raises(InputError, match="threshold=1: expected a part of 1"):
        latent.region(head, 1)
    with pytest.raises(InputError, match="without its eigenbases"):
        replace(latent, bases=None).region(head)
