"""The register of differences, and what follows from it for one that somebody adds."""

import numpy as np
import pytest
import torch

from lssd_learn.errors import InputError
from lssd_learn.latent import LatentSpace, MapNetwork
from lssd_learn.latent import differences as differences_module
from lssd_learn.latent.base_shape import BaseShapes
from lssd_learn.latent.differences import (
    DIFFERENCES,
    Difference,
    area_difference,
    conformal_difference,
    register,
    stack_differences,
)
from lssd_learn.latent.newcomers import push_all


def squared(seen):
    """D^A of the shapes' squared frequencies, a stand-in for a third difference."""
    energy = seen.Y.mT @ (seen.evals[:, :, None] ** 2 * seen.Y)
    return energy / seen.spectrum[-1] ** 2


def weighed(seen):
    """One that reads what an eigenbasis holds: the mass of the vertices where each function is positive."""
    carried = [torch.tensor(np.asarray(basis.evecs.T @ (basis.mass[:, None] * basis.evecs))) for basis in seen.bases]
    return torch.stack([Y.mT @ M.to(Y) @ Y for Y, M in zip(seen.Y, carried, strict=True)])


@pytest.fixture
def third(monkeypatch):
    """A function that registers a difference for the time of a test."""
    monkeypatch.setattr("lssd_learn.latent.differences.DIFFERENCES", table := dict(DIFFERENCES))

    def add(name, compute, **options):
        register(Difference(name, compute, **options))
        return table

    return add


@pytest.fixture(scope="module")
def latent(truncated):
    bases = truncated(8, 30)
    return LatentSpace.fit(MapNetwork.clique(bases), 24, 12)


def test_ours_are_what_the_formulas_say(latent):
    assert list(DIFFERENCES) == ["area", "conformal", "extrinsic"]
    both = stack_differences(latent, ["conformal", "area"])
    Y, evals, spectrum = latent.Y, latent.evals, latent.spectrum
    assert torch.equal(both[:, 0], conformal_difference(Y, evals, spectrum, symmetric=True))
    assert torch.equal(both[:, 1], area_difference(Y))
    tables = DIFFERENCES["area"].tables(latent) | DIFFERENCES["conformal"].tables(latent)
    assert list(tables) == ["area", "conformal", "conformal_symmetric"]
    assert torch.equal(tables["conformal"], conformal_difference(Y, evals, spectrum))


def test_of_many_shapes_a_few_at_once_are_the_same(latent, monkeypatch):
    whole = stack_differences(latent, ["conformal", "area"])
    monkeypatch.setattr(differences_module, "TOGETHER", 3)
    assert torch.equal(stack_differences(latent, ["conformal", "area"]), whole)


@pytest.mark.parametrize("kind", DIFFERENCES)
def test_laws_of_every_difference(latent, kind):
    """Symmetric; the mean, and so a shape like the latent one, is the identity on all functions but null ones."""
    D = stack_differences(latent, [kind])[:, 0]
    torch.testing.assert_close(D, D.mT, rtol=0, atol=1e-12)
    null = not D[:, 0].any()
    assert null == DIFFERENCES[kind].constant_is_null
    expected = torch.eye(12, dtype=torch.float64)
    expected[0, 0] = not null
    torch.testing.assert_close(D.mean(0), expected, rtol=0, atol=1e-8)


def test_a_third_one_is_a_channel_of_spaces_pushes_and_base_shapes(latent, third):
    third("squared", squared, constant_is_null=True)
    stacked = stack_differences(latent, ["area", "squared"])
    assert stacked.shape == (8, 2, 12, 12)
    assert not stacked[:, 1, 0].any()
    pushed = push_all(latent, latent.bases[3:5], ["a", "b"], neighbours=1)
    torch.testing.assert_close(stack_differences(pushed, ["squared"])[:, 0], stacked[3:5, 1], rtol=0, atol=1e-3)
    eye = np.eye(30)
    one = latent.push(latent.bases[3], {3: (eye, eye)})
    torch.testing.assert_close(one.difference("squared"), stacked[3, 1], rtol=0, atol=1e-8)
    torch.testing.assert_close(one.difference("area"), one.area)
    torch.testing.assert_close(torch.diagonal(one.difference("conformal")), torch.diagonal(one.conformal))
    shapes = BaseShapes(MapNetwork.clique(latent.bases), 12)
    area, mine = shapes.differences(2, ["area", "squared"])
    assert torch.equal(area, shapes.differences(2)[0])
    assert mine.shape == (8, 12, 12)


def test_one_that_reads_the_eigenbases(latent, third, tmp_path):
    third("weighed", weighed, asks=["evecs", "mass"])
    both = stack_differences(latent, ["area", "weighed"])
    torch.testing.assert_close(both[:, 0], both[:, 1], rtol=0, atol=1e-5)  # ΦᵀMΦ = I
    torch.testing.assert_close(stack_differences(latent.with_keep(5), ["weighed"])[:, 0], both[:, 1, :5, :5])
    without = LatentSpace.load(latent.save(tmp_path / "space.npz"))
    with pytest.raises(InputError, match="^weighed: expected a latent space with its eigenbases$"):
        stack_differences(without, ["weighed"])
    third("coordinates", weighed, asks=["coordinates"])
    with pytest.raises(InputError, match="^coordinates: expected eigenbases with coordinates, that of shape 0 has"):
        stack_differences(latent, ["coordinates"])


def test_names_and_shapes_are_checked(latent, third):
    table = third("squared", squared)
    third("squared", squared, unit="again")  # a cell of a notebook is run twice
    assert table["squared"].unit == "again"
    with pytest.raises(InputError, match="difference 'area' of .*: there is one of this name in lssd_learn"):
        third("area", squared)
    with pytest.raises(InputError, match="difference 'a b': expected a name of letters"):
        third("a b", squared)
    with pytest.raises(
        InputError, match=r"latent.operators=\[mine\]: expected some of area, conformal, extrinsic, squared"
    ):
        stack_differences(latent, ["mine"])
    third("flat", lambda seen: seen.Y)
    with pytest.raises(InputError, match=r"^flat: expected operators \(8, 12, 12\), got \(8, 30, 12\)"):
        stack_differences(latent, ["flat"])
