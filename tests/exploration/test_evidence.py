import numpy as np
import pytest
import torch

from lssd_learn.collections import Bodies, Bumps, eigenbases
from lssd_learn.exploration import cross_collection, global_variability
from lssd_learn.exploration.evidence import evidence, evidence_stability, local_evidence
from lssd_learn.exploration.pairs import pair_energies
from lssd_learn.exploration.scores import area_under_curve as auc
from lssd_learn.exploration.scores import strongest
from lssd_learn.latent import LatentSpace, MapNetwork
from lssd_learn.shapes import eigenbasis


def field(latent, R, i=0):
    return latent.to_shape(R, i).square().sum(1).numpy()


@pytest.fixture(scope="module")
def four_spheres():
    """The paper's: latent space and area operators; A has no bump on top, B has one."""
    bases = eigenbases(Bumps(), 80, cache=None, workers=1)
    latent = LatentSpace.fit(MapNetwork.clique(bases), 64, 40)
    return latent, latent.differences()[0]


@pytest.mark.parametrize("count", [1, 2])
def test_each_function_sits_on_its_bump(four_spheres, count):
    latent, D = four_spheres
    side, top = (strongest(np.log(latent.bases[i].mass / latent.bases[0].mass)) for i in (1, 2))
    assert auc(field(latent, evidence(D, "AABB", count)), top) > 0.99
    assert auc(field(latent, global_variability(D)[:, None]), side) > 0.99


@pytest.mark.parametrize(
    "parameter",
    ["waist", pytest.param("bust", marks=pytest.mark.slow), pytest.param("upper_arm", marks=pytest.mark.slow)],
)
def test_two_functions_sit_on_both_sides_of_a_body(two_groups, parameter):
    latent, groups, _ = two_groups(parameter)
    D, bodies = latent.differences()[0], Bodies(n=1, topology="notoes_collapse5pc")
    little, much = (eigenbasis(bodies.make({parameter: value}), 2).mass for value in (0, 1))
    grown = strongest(np.log(much / little))
    one, two = (auc(field(latent, evidence(D, groups, count)), grown) for count in (1, 2))
    assert two > 0.96
    assert two > one - 0.002
    R = evidence(D, groups)
    assert auc(local_evidence(latent, R, 0), grown) > 0.97
    assert evidence_stability(latent, D, groups).mean() > 0.9


def test_columns_are_the_functions_by_their_shares(random_operators):
    D, groups = random_operators(7, 5), list("aaabbbb")
    R, alpha = evidence(D, groups, 3), cross_collection(D, groups, 3)
    lengths = R.norm(dim=0)
    energies = pair_energies(D, groups, mean=True)
    largest = torch.linalg.eigvalsh(energies.across - energies.within).flip(0)[:3]
    np.testing.assert_allclose(lengths.square(), largest)
    np.testing.assert_allclose(R, alpha * lengths, atol=1e-12)


def test_all_functions_are_the_positive_part(random_operators):
    D, groups = random_operators(7, 5), list("aaabbbb")
    energies = pair_energies(D, groups, mean=True)
    evals, V = torch.linalg.eigh(energies.across - energies.within)
    R = evidence(D, groups)
    np.testing.assert_allclose(R @ R.T, V * evals.clamp(min=0) @ V.T, atol=1e-12)


def test_a_difference_of_areas_is_found_in_its_size(four_spheres):
    """All of B a tenth larger than A, everywhere: that is what every vertex says."""
    latent, _ = four_spheres
    D = torch.stack([(1.1 if i > 1 else 1) * torch.eye(40).double() for i in range(4)])
    np.testing.assert_allclose(local_evidence(latent, evidence(D, "AABB"), 1), 0.1, atol=1e-9)


def test_equal_functions_may_be_mixed(four_spheres):
    """Two equal copies of a difference: any rotation of the two functions is as good, and gives the same field."""
    latent, _ = four_spheres
    rng = np.random.default_rng(0)
    change = torch.zeros(40, 40, dtype=torch.float64)
    change[3, 3] = change[7, 7] = 0.5
    D = torch.stack([torch.eye(40) + (i < 2) * change for i in range(4)]).double()
    turn = torch.from_numpy(np.linalg.qr(rng.normal(size=(2, 2)))[0])
    R = evidence(D, "aabb", 2)
    np.testing.assert_allclose(field(latent, R @ turn), field(latent, R), atol=1e-12)
    np.testing.assert_allclose(R.square().sum(1)[[3, 7]], 0.25, atol=1e-9)


def test_a_difference_without_noise_stays_where_it_is(four_spheres):
    latent, D = four_spheres
    same = torch.stack([D[0], D[0], D[2], D[2]])
    np.testing.assert_allclose(evidence_stability(latent, same, "aabb"), 1, atol=1e-9)


def test_chance_does_not_stay(four_spheres, random_operators):
    latent, _ = four_spheres
    assert evidence_stability(latent, random_operators(4, 40), "aabb").mean() < 0.7


def test_shapes_without_a_label_are_left_out(four_spheres, random_operators):
    latent, D = four_spheres
    with_others = torch.cat([D, D[:1] + random_operators(1, 40)])
    found = evidence_stability(latent, with_others, [*"AABB", None])
    np.testing.assert_allclose(found, evidence_stability(latent, D, "AABB"), atol=1e-12)
