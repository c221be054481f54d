"""On deformed spheres, and on these turned, shifted and mirrored, with vertex identity as maps."""

import numpy as np
import pytest
import torch

from lssd_learn.collections import ShapeList, eigenbases
from lssd_learn.errors import InputError
from lssd_learn.exploration.models.design import design
from lssd_learn.exploration.models.strata import strata
from lssd_learn.exploration.surfaces.coordinates import coordinates
from lssd_learn.exploration.surfaces.lent import Lender
from lssd_learn.exploration.surfaces.morphs import group_morphs, model_morphs, score_morphs
from lssd_learn.latent import LatentSpace, MapNetwork
from lssd_learn.shapes import Mesh
from lssd_learn.shapes.kabsch import kabsch

N = 8
GROWTH = np.linspace(0, 0.4, N)
KIND = np.array(["b", "a"] * (N // 2), dtype=object)


@pytest.fixture(scope="module")
def shapes(deformed_spheres):
    """One sphere, ever taller, with a dent on the side of every second."""
    ball = deformed_spheres(1, 2)[0]
    axis = ball.vertices / np.linalg.norm(ball.vertices, axis=1, keepdims=True)
    side = np.exp(-np.square(axis - [0.9, 0.3, 0.3]).sum(1) / 0.3)[:, None]
    return [
        Mesh(ball.vertices * [1, 1, 1 + g] * (1 - 0.2 * side * (kind == "b")), ball.faces)
        for g, kind in zip(GROWTH, KIND, strict=True)
    ]


def space(shapes):
    bases = eigenbases(ShapeList(shapes), 40, cache=None)
    return LatentSpace.fit(MapNetwork.clique(bases), 36, 36)


@pytest.fixture(scope="module")
def latent(shapes):
    return space(shapes)


@pytest.fixture(scope="module")
def found(latent):
    return coordinates(latent, 2)


def off(points, goal):
    """Root mean square distance, the one laid on the other, in parts of the size of the other."""
    a, b = points - points.mean(0), goal - goal.mean(0)
    return float(np.linalg.norm(a @ kabsch(a, b) - b) / np.linalg.norm(b))


def test_the_base_stays_as_it_is(latent, found, shapes):
    lender = Lender.of(latent, found, shapes[2])
    np.testing.assert_allclose(lender.vertices(found.x[2]), shapes[2].vertices, atol=1e-9)
    assert not found.mirrored.any()
    assert lender.surface(found.x[2]).connectivity == shapes[2].connectivity


def test_coordinates_of_another_shape_draw_it(latent, found, shapes):
    lender = Lender.of(latent, found, shapes[2])
    for i in (0, 5, 7):
        near, far = off(lender.vertices(found.x[i]), shapes[i].vertices), off(shapes[2].vertices, shapes[i].vertices)
        assert near < 0.012
        assert near < 0.3 * far or far < 0.02


def test_how_shapes_lie_makes_no_difference_nor_does_their_side_where_it_is_seen(found, shapes):
    rng, moved = np.random.default_rng(0), []
    for i, shape in enumerate(shapes):
        turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        turn *= np.sign(np.linalg.det(turn)) * (-1 if i in (1, 4) else 1)
        turn, shift = (np.eye(3), np.zeros(3)) if i == 2 else (turn, rng.normal(size=3))
        moved.append(Mesh(shape.vertices @ turn + shift, shape.faces))
    turned = space(moved)
    again = coordinates(turned, 2)
    assert again.mirrored.tolist() == [i in (1, 4) for i in range(N)]
    one, other = (torch.cdist(*(torch.tensor(f.x.reshape(N, -1)),) * 2) for f in (found, again))
    torch.testing.assert_close(one, other, atol=1e-3 * float(one.max()), rtol=0)
    assert not coordinates(turned, 2, "forbid").mirrored.any()
    with pytest.raises(InputError, match="mirror=left: expected one of auto, forbid, allow"):
        coordinates(turned, 2, "left")


def model(formula="~ growth + kind", **more):
    made = design(formula, {"growth": GROWTH, "kind": KIND, **more}, [f"s{i}" for i in range(N)])
    return made, strata(made, None, permutations=9)


def test_a_model_draws_what_it_says(latent, found, shapes):
    lender = Lender.of(latent, found, shapes[2])
    along, across = model_morphs(found.x, *model(), 2)
    assert (along.title, across.title) == ("growth", "kind: a → b")
    assert along.at == pytest.approx((0.2 - 2 * GROWTH.std(ddof=1), 0.2 + 2 * GROWTH.std(ddof=1)))
    assert across.ends == ("a", "b")
    s = (GROWTH[7] - 0.2) / (along.at[1] - 0.2)
    dented = shapes[7].vertices.copy() if KIND[7] == KIND[2] else None
    goal = shapes[6].vertices * [1, 1, (1 + GROWTH[7]) / (1 + GROWTH[6])] if dented is None else dented
    assert off(lender.vertices(along.x(s)), goal) < 0.012  # of the kind of shape 2, as tall as the tallest
    middle = [(shapes[i].vertices / [1, 1, 1 + GROWTH[i]]) * [1, 1, 1.2] for i in (0, 1)]
    for s, goal in ((1, middle[0]), (-1, middle[1])):  # shape 0 is of kind b
        assert off(lender.vertices(across.x(s)), goal) < 0.012
    assert off(middle[0], middle[1]) > 0.03


def test_slopes_of_groups_and_what_cannot_be_drawn(found):
    titles = [morph.title for morph in model_morphs(found.x, *model("~ growth * kind"), 2)]
    assert titles == ["growth", "kind: a → b", "growth of a", "growth of b"]
    assert model_morphs(found.x, *model("~ poly(growth, 2)"), 2) == []


def test_scores_and_groups(found):
    flat = found.x.reshape(N, -1) - found.x.reshape(N, -1).mean(0)
    U, sizes, Vt = np.linalg.svd(flat, full_matrices=False)
    (morph,) = score_morphs(found.x, {"PC1": U[:, 0] * sizes[0], "nothing": np.ones(N)})
    step = morph.step.ravel()
    np.testing.assert_allclose(step / np.linalg.norm(step), Vt[0], atol=1e-9)
    assert np.linalg.norm(step) == pytest.approx(2 * sizes[0] / np.sqrt(N - 1))
    (pair,) = group_morphs(found.x, "kind", list(KIND[:-1]) + [None])
    np.testing.assert_allclose(pair.x(1), found.x[:-1][KIND[:-1] == "b"].mean(0), atol=1e-9)
    np.testing.assert_allclose(pair.x(-1), found.x[:-1][KIND[:-1] == "a"].mean(0), atol=1e-9)
    assert len(group_morphs(found.x, "each", list("abcdefgh"))) == 8
