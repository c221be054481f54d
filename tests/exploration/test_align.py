"""Two collections paired without maps between them."""

import numpy as np
import pytest
import torch
from scipy.spatial.transform import Rotation

from lssd_learn.collections import Bodies
from lssd_learn.errors import InputError
from lssd_learn.exploration import align, descriptors
from lssd_learn.latent import LatentSpace, MapNetwork
from lssd_learn.shapes import eigenbasis


@pytest.fixture(scope="module")
def women_and_men():
    """Two latent spaces of ten bodies with the same parameters; the men have twice the vertices, and bend."""
    bodies = [Bodies(n=10, topology=f"notoes_collapse{size}pc", vary_age=True) for size in (5, 10)]
    parameters = bodies[0].parameters.copy()
    parameters[:, 12] = 0.67
    spaces = []
    for gender, pose in enumerate(["rest", "bend"]):
        parameters[:, 13] = gender
        bases = [eigenbasis(bodies[gender].make(p, pose), 40) for p in parameters]
        spaces.append(LatentSpace.fit(MapNetwork.clique(bases), 32, 20).differences(symmetric=True))
    return spaces


def positive(n, m, seed):
    X = np.random.default_rng(seed).normal(size=(n, m, m))
    return torch.matrix_exp(torch.from_numpy(X + X.swapaxes(1, 2)) / 4)


@pytest.mark.parametrize("channels", [1, 2])
def test_every_woman_finds_her_man(women_and_men, channels):
    """A random pairing has one right of ten on average."""
    women, men = (torch.stack(operators[:channels], dim=1) for operators in women_and_men)
    order = np.random.default_rng(0).permutation(10)
    found = align(women, men[order])
    assert found.pairs[:, 0].tolist() == list(range(10))
    assert (order[found.pairs[:, 1]] == np.arange(10)).all()


def test_descriptors_do_not_depend_on_the_basis():
    D = positive(5, 4, 0)
    R = torch.from_numpy(np.linalg.qr(np.random.default_rng(1).normal(size=(4, 4)))[0])
    x = descriptors(D)
    assert x.shape == (5, 4)
    torch.testing.assert_close(descriptors(R.T @ D @ R), x)
    torch.testing.assert_close(descriptors(3 * D), x)  # the mean of the class is taken away
    logs = torch.linalg.eigvalsh(D).log()
    torch.testing.assert_close(x, logs - logs.mean(0))


def test_the_pairing_has_the_least_cost():
    """Against all pairings of four with four."""
    from itertools import permutations

    first, second = positive(4, 3, 0), positive(4, 3, 1)
    found = align(first, second)
    costs = torch.cdist(descriptors(first), descriptors(second))
    torch.testing.assert_close(found.costs, costs[found.pairs[:, 0], found.pairs[:, 1]])
    least = min(float(costs[range(4), list(p)].sum()) for p in permutations(range(4)))
    assert float(found.costs.sum()) == pytest.approx(least)


def test_the_smaller_collection_is_paired_in_whole():
    D = positive(6, 3, 0)
    for first, second in ((D, D[:4]), (D[:4], D)):
        found = align(first, second)
        assert found.pairs.shape == (4, 2)
        assert len(set(found.pairs[:, 0].tolist())) == len(set(found.pairs[:, 1].tolist())) == 4
    assert align(D, D).pairs[:, 1].tolist() == list(range(6))
    assert float(align(D, D.numpy()).costs.max()) == 0


def test_a_shape_that_nobody_is_like_stays_alone():
    D = positive(40, 3, 0)
    noise = 0.01 * torch.from_numpy(np.random.default_rng(0).normal(size=40))
    near = D * noise.exp()[:, None, None]
    near[2] = torch.diag(torch.tensor([0.05, 1, 20]))
    found = align(D, near, 3)
    assert found.pairs.tolist() == [[i, i] for i in range(40) if i != 2]
    assert align(D, near).pairs.shape == (40, 2)
    assert align(D, D[:9], 2).pairs.shape[0] <= 9
    with pytest.raises(InputError, match="unmatched=0: expected a number above 0"):
        align(D, D, 0)


def test_giving_up_a_pair_costs_the_limit():
    """Against all choices of pairs."""
    from itertools import permutations

    first, second = positive(4, 3, 0), positive(4, 3, 1)
    costs = torch.cdist(descriptors(first), descriptors(second))
    for unmatched in (0.8, 1.2, 2):
        limit = unmatched * float(costs.amin(1).median())
        least = min(float(costs[range(4), list(p)].clamp(max=limit).sum()) for p in permutations(range(4)))
        found = align(first, second, unmatched)
        assert float(found.costs.sum()) + limit * (4 - len(found.costs)) == pytest.approx(least)


def test_the_constant_of_conformal_operators_is_left_out(women_and_men):
    _, conformal = women_and_men[0]
    assert descriptors(conformal).shape == (10, 19)
    assert descriptors(torch.stack(women_and_men[0], dim=1).float()).shape == (10, 39)


def test_borders():
    D = positive(3, 4, 0)
    with pytest.raises(InputError, match="align: expected as many functions in both collections, got 4 and 3"):
        align(D, positive(3, 3, 0))
    with pytest.raises(InputError, match=r"D: expected operators \(n, m, m\) or \(n, channels, m, m\), got \(4, 4\)"):
        align(D[0], D)
    with pytest.raises(InputError, match="expected symmetric operators"):
        align(torch.from_numpy(Rotation.random(3, random_state=0).as_matrix()), D)
