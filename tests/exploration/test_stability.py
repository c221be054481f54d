"""Canonical latent bases stay where they are when the collection grows, plain ones turn: the paper's Figure (b, c)."""

import numpy as np
import pytest
import torch

from lssd_learn.errors import InputError
from lssd_learn.exploration import change_of_basis, off_band, principal_angles
from lssd_learn.latent import LatentSpace, MapNetwork, consistent_basis


@pytest.fixture(scope="module")
def grown(truncated):
    """A function (canonical, functions) → bases on the first eight bodies, of these alone and of sixteen."""

    def make(canonical, functions):
        networks = [MapNetwork.clique(truncated(n, 40)) for n in (8, 16)]
        if canonical:
            return [LatentSpace.fit(network, 32, functions).Y[:8] for network in networks]
        return [consistent_basis(network.form(), 32).Y[:8, :, :functions] for network in networks]

    return make


def diagonality(T):
    return float(T.diagonal().square().sum() / T.square().sum())


@pytest.mark.slow
@pytest.mark.parametrize("functions", [5, 10, 20])
def test_canonical_functions_turn_less_than_plain_ones(grown, functions):
    canonical, plain = (float(principal_angles(*grown(kind, functions))[0]) for kind in (True, False))
    assert canonical < 0.15
    assert plain > 3 * canonical


@pytest.mark.slow
def test_the_change_of_canonical_basis_is_diagonal(grown):
    canonical, plain = (diagonality(change_of_basis(*grown(kind, 20))) for kind in (True, False))
    assert canonical > 0.99
    assert plain < 0.9


def test_energy_off_a_band():
    T = torch.diag(torch.tensor([3.0, 1, 1, 1]))
    T[0, 2], T[3, 0] = 1.0, 2.0
    assert [off_band(T, width) for width in range(4)] == [5 / 17, 5 / 17, 4 / 17, 0]
    assert off_band(-7 * torch.eye(3, 5)) == 0
    assert off_band(np.array([[0.0, 1], [1, 0]])) == 1


def test_angles_are_known_where_they_can_be_seen():
    first = torch.eye(6).reshape(2, 3, 6)[..., :2]
    turned = first.clone()
    turned[0, :, 1] = torch.tensor([0, np.cos(0.3), np.sin(0.3)])
    angles = principal_angles(first, turned)
    np.testing.assert_allclose(angles, [0.3, 0], atol=1e-7)
    np.testing.assert_allclose(change_of_basis(first, turned), [[1, 0], [0, np.cos(0.3)]], atol=1e-7)
    assert principal_angles(first, turned[..., :1]).shape == (1,)


def test_angles_do_not_see_a_change_of_basis(truncated):
    Y = LatentSpace.fit(MapNetwork.clique(truncated(6, 30)), 24, 10).Y
    R = np.random.default_rng(0).normal(size=(10, 10))
    assert float(principal_angles(Y, Y.numpy() @ R).max()) < 1e-9
    np.testing.assert_allclose(change_of_basis(Y, Y @ torch.from_numpy(R)), R, atol=1e-9)


def test_bases_on_other_shapes_are_refused():
    with pytest.raises(InputError, match="on the same shapes"):
        principal_angles(torch.zeros(3, 5, 2), torch.zeros(2, 5, 2))
    with pytest.raises(InputError, match="on the same shapes"):
        change_of_basis(torch.zeros(3, 5, 2), torch.zeros(5, 2))
