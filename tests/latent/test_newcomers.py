"""New shapes in an old space: as near as a fit would have put them, and refused where nothing corresponds."""

from dataclasses import replace

import numpy as np
import pytest
import torch

from lssd_learn.errors import InputError
from lssd_learn.latent import LatentSpace, MapNetwork, push_all
from lssd_learn.latent.newcomers import check_corresponds, corresponding


@pytest.fixture(scope="module")
def space(many_bodies):
    """Of the first 40 bodies, 80 eigenfunctions, 40 kept."""
    return LatentSpace.fit(MapNetwork.clique(many_bodies[:40]), 64, 40)


def names(bases):
    return [f"new_{i}" for i in range(len(bases))]


def without(space, i):
    """The same space, which has forgotten shape i."""
    rest = [j for j in range(len(space)) if j != i]
    return replace(space, Y=space.Y[rest], evals=space.evals[rest], bases=[space.bases[j] for j in rest])


def test_old_shapes_come_back_where_they_were_fitted(space):
    """Each with its own entry left out, relative to the deviation of the collection: area to 1 %, conformal to 3 %."""
    fitted, errors = space.differences(symmetric=True), []
    for i in range(0, 40, 5):
        pushed = push_all(without(space, i), space.bases[i : i + 1], ["again"]).differences(symmetric=True)
        errors.append(
            [
                float((new[0] - old[i]).norm() / (old - old.mean(0)).square().sum((1, 2)).mean().sqrt())
                for new, old in zip(pushed, fitted, strict=True)
            ]
        )
    area, conformal = np.array(errors).T
    assert area.mean() < 0.01
    assert area.max() < 0.02
    assert conformal.mean() < 0.04
    assert conformal.max() < 0.09


def test_many_at_once_are_each_pushed_alone(space, many_bodies):
    bases = many_bodies[40:44]
    new = push_all(space, bases, names(bases))
    assert new.Y.shape == (4, 80, 40)
    assert new.names == ("new_0", "new_1", "new_2", "new_3")
    torch.testing.assert_close(new.spectrum, space.spectrum)
    for i, basis in enumerate(bases):
        torch.testing.assert_close(new.Y[i], push_all(space, [basis], ["alone"]).Y[0])
        np.testing.assert_array_equal(new.evals[i], basis.evals)


def test_neighbours_are_the_nearest_of_those_with_the_same_faces(space, many_bodies):
    basis = many_bodies[40]
    nearest = space.neighbours(basis.evals, 6)
    assert corresponding(space, basis, "new", 5) == nearest[:5]
    other = replace(space.bases[nearest[1]], connectivity="other")
    bases = [other if i == nearest[1] else b for i, b in enumerate(space.bases)]
    assert corresponding(replace(space, bases=bases), basis, "new", 5) == [nearest[0], *nearest[2:]]
    assert len(corresponding(space, basis, "new", 99)) == 40


@pytest.mark.parametrize(("connectivity", "told"), [("other", "vertices and other faces"), (None, "points and no")])
def test_a_shape_that_corresponds_to_none_is_named(space, many_bodies, connectivity, told):
    stranger = replace(many_bodies[41], connectivity=connectivity)
    with pytest.raises(
        InputError, match=rf"new_1: expected a mesh in vertex corr.*\(615 vertices\), or .*; got 615 {told}"
    ):
        push_all(space, [many_bodies[40], stranger], ["new_0", "new_1"])
    with pytest.raises(InputError, match=rf"new_1: expected .* {told}"):
        check_corresponds(space, "new_1", connectivity, 615)


def test_what_is_lacking_or_out_of_range_is_told(space, many_bodies):
    with pytest.raises(InputError, match="loaded without its eigenbases"):
        push_all(replace(space, bases=None), many_bodies[40:41], ["new"])
    with pytest.raises(InputError, match="neighbours=0: expected a whole number, 1 or more"):
        push_all(space, many_bodies[40:41], ["new"], neighbours=0)
    with pytest.raises(InputError, match="expected 80 eigenvalues"):
        push_all(space, [many_bodies[40].truncate(20)], ["new"])


def test_another_unit_of_length_is_told(space, many_bodies, caplog):
    basis = many_bodies[40]
    in_millimetres = replace(basis, evals=basis.evals * 1e-6, evecs=basis.evecs * 1e-3, mass=basis.mass * 1e6)
    push_all(space, [basis, in_millimetres], ["metres", "millimetres"])
    (line,) = caplog.messages
    assert line.startswith("1 of 2 shapes (millimetres, …) are 1,0")  # about a thousand times, as bodies differ
    assert "times larger than those the model was trained on: in mm, those in m?" in line
