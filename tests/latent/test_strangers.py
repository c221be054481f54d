"""Shapes that correspond to none of a latent space, pushed through computed maps."""

from functools import partial

import numpy as np
import pytest
import torch
from scipy.spatial.transform import Rotation

from lssd_learn.collections import Bodies, Remeshed, ShapeList, eigenbases
from lssd_learn.collections.chosen import Chosen
from lssd_learn.errors import InputError
from lssd_learn.latent.newcomers import push_all
from lssd_learn.latent.strangers import choose_neighbours, push_strangers
from lssd_learn.maps import AutoMaps, RegistrationMaps, VertexMaps, registration
from lssd_learn.maps.stored import STAGE
from lssd_learn.pipeline import Pipeline
from lssd_learn.shapes import Mesh, PointCloud
from lssd_learn.shapes.sampling import sample_with_corners


@pytest.fixture(scope="module")
def known():
    """Twenty-four bodies, three of each pose."""
    return Bodies(n=24, topology="notoes_collapse5pc")


@pytest.fixture(scope="module")
def space(known):
    return Pipeline(known, k=30, size=20, keep=10, cache=None, workers=1).latent


@pytest.fixture(scope="module")
def strangers(known):
    """Three of them again, each with a mesh of its own."""
    return Remeshed(Chosen([(known, i) for i in (0, 11, 22)]), vertices=(450, 550))


@pytest.fixture(scope="module")
def bases(strangers):
    return eigenbases(strangers, 30, cache=None, workers=1)


def test_the_shape_itself_is_the_nearest_where_it_is_not_left_out(known, space, strangers, bases):
    chosen = choose_neighbours(space, known, strangers, bases, 2, 24)
    assert [some[0] for some in chosen] == [0, 11, 22]
    others = choose_neighbours(space, known, strangers, bases, 2, 24, own=[0, 11, 22])
    assert [some[0] for some in others] == [some[1] for some in chosen]
    by_spectrum = choose_neighbours(space, known, strangers, bases, 3, 3)
    assert by_spectrum == [space.neighbours(basis.evals, 3) for basis in bases]
    for numbers in ((0, 5), (25, 30), (3, 2)):
        with pytest.raises(InputError, match="expected a whole number"):
            choose_neighbours(space, known, strangers, bases, *numbers)


def test_where_strangers_stand_does_not_matter(known, space, strangers, bases):
    """Geodetic coordinates have no digits left as float32: what is taken off them is their own."""
    far = ShapeList([Mesh(shape.vertices + [4e6, 1e6, 5e6], shape.faces) for shape in strangers])
    near = choose_neighbours(space, known, strangers, bases, 3, 24)
    assert choose_neighbours(space, known, far, bases, 3, 24) == near
    moved = ShapeList([Mesh(known[i].vertices - [4e6, 1e6, 5e6], known[i].faces) for i in range(len(known))])
    assert choose_neighbours(space, moved, far, bases, 3, 24) == near


def test_how_strangers_lie_does_not_matter_where_maps_ask_for_nothing(known, space, strangers, bases):
    turns = Rotation.random(3, random_state=0).as_matrix()
    lying = ShapeList([Mesh(shape.vertices @ R, shape.faces) for shape, R in zip(strangers, turns, strict=True)])
    as_they_lie = choose_neighbours(space, known, lying, bases, 1, 24)
    assert as_they_lie != [[0], [11], [22]]
    assert choose_neighbours(space, known, lying, bases, 1, 24, turned=True) == [[0], [11], [22]]
    assert AutoMaps(bases, strangers).turned
    assert not RegistrationMaps(bases, strangers).turned


def test_a_remeshed_shape_gets_the_operator_of_its_shape(known, space, strangers, bases):
    pushed = push_strangers(space, known, strangers, bases, RegistrationMaps, 1, 24).space
    area, expected = pushed.differences()[0], space.differences()[0]
    spread = (expected - torch.eye(10)).flatten(1).norm(dim=1).square().mean().sqrt()
    away = (area - expected[[0, 11, 22]]).flatten(1).norm(dim=1)
    assert (away < 0.35 * spread).all()
    assert pushed.names == ("body_0000", "body_0011", "body_0022")
    assert pushed.bases is not None
    assert len(pushed.bases) == 3


def test_it_is_the_push_through_the_maps_of_the_pairs(known, space, strangers, bases):
    short = partial(RegistrationMaps, rounds=2)
    pushed = push_strangers(space, known, strangers, bases, short, 1, 24, own=[0, 11, 22]).space
    ((i,), *_) = choose_neighbours(space, known, strangers, bases, 1, 24, own=[0, 11, 22])
    there = registration(space.bases[i], bases[0], known[i], strangers[0], rounds=2)
    pair = short([space.bases[i], bases[0]], ShapeList([known[i], strangers[0]]))
    pair.known = 1
    back = pair(1, 0)
    torch.testing.assert_close(pushed.Y[0], space.push(bases[0], {i: (there, back)}).basis)


def test_maps_are_found_again_in_the_cache(known, strangers, cache):
    pipeline = Pipeline(known, k=30, size=20, keep=10, cache=cache, workers=1)
    stored = eigenbases(strangers, 30, cache=cache, workers=1)

    def push(**more):
        how = {"cache": cache, "workers": 1, "described": ["fast"], **more}
        return push_strangers(
            pipeline.latent, known, strangers, stored, partial(RegistrationMaps, rounds=1), **how
        ).space

    def entries():
        return sorted(path.stem for path in (cache.root / STAGE).glob("*/*.arrays"))

    first, made = push(), entries()
    assert len(made) == 3
    torch.testing.assert_close(push().Y, first.Y)
    assert entries() == made
    push(described=["other"])
    assert len(entries()) == 6
    with pytest.raises(InputError, match=r"body_\d+ and body_0000 are not in vertex correspondence"):
        push_strangers(pipeline.latent, known, strangers, stored, VertexMaps)


class Rated(RegistrationMaps):
    """Maps that know their quality: good to some of the shapes, bad to others."""

    level = 0.5
    good = frozenset()

    def quality(self, i, j):
        return 0.9 if min(i, j) in self.good else 0.2

    def unreached(self, i, j):
        return (0.04, 0.002) if j == 25 else (0.002, 0.001)


def test_maps_that_are_not_to_be_trusted_are_left_out_where_there_are_others(
    known, space, strangers, bases, caplog, monkeypatch
):
    monkeypatch.setattr("lssd_learn.latent.strangers.mixtures", lambda starts, *_: [None] * len(starts.chosen))
    chosen = choose_neighbours(space, known, strangers, bases, 3, 24)
    Rated.good = frozenset({chosen[0][1], chosen[1][0], chosen[1][1]} - set(chosen[2]))
    short = partial(Rated, rounds=1)
    found = push_strangers(space, known, strangers, bases, short, 3, 24)
    assert caplog.messages == [
        "1 of 3 shapes seem to lack a part that the training shapes have, or to be of another kind: body_0011"
    ]
    left = [[i for i in some if i in Rated.good] for some in chosen]
    assert found.trusted.tolist() == [len(some) for some in left]
    assert found.trusted[0] >= 1
    assert found.trusted[2] == 0
    np.testing.assert_allclose(found.quality, [0.9 if some else 0.2 for some in left])
    assert found.doubtful.tolist() == [not some for some in left]
    maps = short([*space.bases, *bases], Chosen([(known, i) for i in range(24)] + [(strangers, j) for j in range(3)]))
    maps.known = 24
    for j, some in enumerate(left):
        through = {i: (maps(i, 24 + j), maps(24 + j, i)) for i in some or chosen[j]}
        torch.testing.assert_close(found.space.Y[j], space.push(bases[j], through).basis)


@pytest.fixture(scope="module")
def people():
    """Thirty people with their arms down, their latent space, and two more."""
    model = Bodies(n=32, topology="notoes_collapse5pc")
    shapes = [model.make(values, "arms_down") for values in model.parameters]
    known = ShapeList(shapes[:30])
    return known, Pipeline(known, k=30, size=20, keep=10, cache=None, workers=1).latent, ShapeList(shapes[30:])


def _away(pushed, space, new):
    """How far area operators are from those of the shapes in correspondence, in spreads of the known ones."""
    true = push_all(space, eigenbases(new, 30, cache=None, workers=1), ["new"] * len(new), 5).differences()[0]
    spread = (space.differences()[0] - torch.eye(10)).flatten(1).norm(dim=1).square().mean().sqrt()
    return (pushed.differences()[0] - true).flatten(1).norm(dim=1) / spread


def test_a_mixture_of_known_shapes_is_pushed_as_such(people, caplog):
    """What bending leaves open, how far points slid along the surface, shapes in correspondence tell."""
    known, space, more = people
    new = ShapeList(list(more)[:1])
    order = np.random.default_rng(0).permutation(len(new[0].vertices))
    faces = np.argsort(order)[new[0].faces]
    strangers = ShapeList([Mesh(new[0].vertices[order], faces)])
    bases = eigenbases(strangers, 30, cache=None, workers=1)
    caplog.set_level("INFO")
    how = {"candidates": 30, "workers": 1}
    pushed = push_strangers(space, known, strangers, bases, partial(RegistrationMaps, rounds=2), **how).space
    assert "1 of 1 shapes are mixtures of the training shapes, and pushed as such" in caplog.messages
    assert _away(pushed, space, new) < 0.02


def test_clouds_that_lie_anyhow_need_no_map_where_they_are_mixtures_and_else_are_doubted(people, monkeypatch, caplog):
    known, space, new = people
    rng = np.random.default_rng(0)
    turns = Rotation.random(2, random_state=1).as_matrix()
    sitting = Bodies(n=1, topology="notoes_collapse5pc").make([0.5] * 12, "sitting")
    strangers = ShapeList([PointCloud(sample_with_corners(shape, 2000, rng)[0] @ turn + 3)
                           for shape, turn in zip((new[0], sitting), turns, strict=True)])  # fmt: skip
    caplog.set_level("INFO")
    asked, pair = [], AutoMaps.pair
    monkeypatch.setattr(AutoMaps, "pair", lambda maps, i, j: asked.append(j) or pair(maps, i, j))
    bases = eigenbases(strangers, 30, cache=None, workers=1)
    found = push_strangers(space, known, strangers, bases, AutoMaps, candidates=30, workers=1)
    assert asked == [31]
    assert "1 of 2 are no mixtures, and read through maps alone, less well: 1" in caplog.messages
    assert np.isnan(found.quality).all()
    assert found.doubtful.tolist() == [False, True]
    assert _away(found.space.some([0]), space, ShapeList([new[0]])) < 0.2
