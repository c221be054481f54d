"""The choices of the config group `maps`: who is asked for which pair, and the whole pipeline on them."""

import sys
from functools import partial
from inspect import signature
from pathlib import Path

import numpy as np
import pytest
import torch
from hydra.utils import instantiate
from omegaconf import OmegaConf

from lssd_learn import maps as every_map
from lssd_learn.collections import Bodies, ShapeList
from lssd_learn.errors import InputError
from lssd_learn.maps import (
    AdjointMaps,
    AutoMaps,
    ComputedMaps,
    KernelMatchingMaps,
    LandmarkMaps,
    RegistrationMaps,
    SplineMaps,
    VertexMaps,
    adjoint,
    from_correspondence,
    kernel_matching,
    landmarks,
    registration,
    to_vertices,
)
from lssd_learn.pipeline import Pipeline
from lssd_learn.shapes import eigenbasis
from lssd_learn.shapes.sampling import farthest_points

CONF = Path(__file__).parents[2] / "conf" / "maps"
KINDS = {
    "auto": AutoMaps,
    "landmarks": LandmarkMaps,
    "adjoint": AdjointMaps,
    "kernel_matching": KernelMatchingMaps,
    "registration": RegistrationMaps,
}


@pytest.fixture(scope="module")
def mixed(meshes, shuffled):
    """Six deformed spheres of 162 vertices, the last three with vertices in another order, and eight landmarks each."""
    order = np.random.default_rng(0).permutation(162)
    others = [shuffled(mesh)[0] for mesh in meshes[3:]]
    back = np.argsort(shuffled(meshes[0])[1])
    assert len({mesh.connectivity for mesh in others}) == 1
    collection = ShapeList([*meshes[:3], *others])
    marks = {f"mark {v}": int(v) for v in order[:8]}
    collection.landmarks = [marks] * 3 + [{name: int(back[v]) for name, v in marks.items()}] * 3
    collection.key = "mixed"
    return collection


@pytest.fixture(scope="module")
def bases(mixed):
    return [eigenbasis(mesh, 16) for mesh in mixed]


def vertices_of(collection, i):
    return list(collection.landmarks[i].values())


@pytest.mark.parametrize("name", KINDS)
def test_every_yaml_makes_maps(name, mixed, bases):
    maps = instantiate(OmegaConf.load(CONF / f"{name}.yaml"))(bases, mixed)
    assert type(maps) is KINDS[name]
    assert not maps.is_identity
    assert KINDS[name](bases[:3], ShapeList(list(mixed)[:3])).is_identity


def test_the_yaml_holds_the_defaults_of_the_class(mixed, bases):
    for name, kind in KINDS.items():
        given = {k: v for k, v in OmegaConf.load(CONF / f"{name}.yaml").items() if not k.startswith("_")}
        assert vars(kind(bases, mixed, **given)) == vars(kind(bases, mixed))


@pytest.mark.parametrize("kind", KINDS.values())
def test_one_connectivity_is_identity_whatever_is_chosen(kind, mixed, bases, monkeypatch):
    monkeypatch.setattr(kind, "vertex_maps", None)
    maps = kind(bases, mixed)
    np.testing.assert_array_equal(maps(1, 2), from_correspondence(bases[1], bases[2]))
    np.testing.assert_array_equal(maps(5, 3), from_correspondence(bases[5], bases[3]))


@pytest.mark.parametrize("kind", KINDS.values())
def test_a_correspondence_can_be_ignored(kind, mixed, bases, monkeypatch):
    backwards = np.arange(162)[::-1]
    monkeypatch.setattr(kind, "pair", lambda *_: {"there": backwards, "back": backwards})
    maps = kind(bases[:3], ShapeList(list(mixed)[:3]), correspondence="none")
    assert not maps.is_identity
    np.testing.assert_array_equal(maps(1, 2), from_correspondence(bases[1], bases[2], backwards))
    with pytest.raises(InputError, match="maps.correspondence=no: expected auto or none"):
        kind(bases, mixed, correspondence="no")


def test_both_directions_are_computed_together_and_once(mixed, bases):
    asked = []

    class Recorded(ComputedMaps):
        def vertex_maps(self, i, j):
            asked.append((i, j))
            return np.arange(162), np.arange(162)[::-1]

    maps = Recorded(bases, mixed)
    np.testing.assert_array_equal(maps(4, 1), from_correspondence(bases[4], bases[1], np.arange(162)[::-1]))
    np.testing.assert_array_equal(maps(1, 4), from_correspondence(bases[1], bases[4], np.arange(162)))
    maps(4, 1), maps(0, 4)
    assert asked == [(1, 4), (0, 4)]


def test_they_are_the_functions_of_their_names(mixed, bases):
    a, b, marks_a, marks_b = bases[0], bases[4], vertices_of(mixed, 0), vertices_of(mixed, 4)
    maps = LandmarkMaps(bases, mixed, functions=12, refined=None)
    np.testing.assert_allclose(maps(0, 4), landmarks(a, b, marks_a, marks_b, functions=12, refined=None), atol=1e-12)
    np.testing.assert_allclose(maps(4, 0), landmarks(b, a, marks_b, marks_a, functions=12, refined=None), atol=1e-12)
    maps = KernelMatchingMaps(bases, mixed, samples=60, steps=3)
    np.testing.assert_array_equal(maps(0, 4), kernel_matching(a, b, mixed[0], mixed[4], samples=60, steps=3))
    maps = RegistrationMaps(bases, mixed, rounds=4, functions=9)
    np.testing.assert_array_equal(maps(0, 4), registration(a, b, mixed[0], mixed[4], rounds=4, functions=9))
    maps = AdjointMaps(bases, mixed, functions=12, trusted=12, refined=None)
    small = a.truncate(12), b.truncate(12)
    C, back = adjoint(*small, marks_a, marks_b)
    np.testing.assert_array_equal(maps(0, 4), from_correspondence(a, b, to_vertices(*small, C)))
    np.testing.assert_array_equal(maps(4, 0), from_correspondence(b, a, to_vertices(*small[::-1], back)))


def test_adjoint_maps_do_without_landmarks(mixed, bases, caplog):
    bare = ShapeList(list(mixed))
    for maps in (AdjointMaps(bases, bare), AdjointMaps(bases, mixed, landmarks=0)):
        caplog.clear()
        assert maps(0, 4).shape == (16, 16)
        assert "without landmarks; symmetric shapes may be mapped mirrored" in caplog.text
    with pytest.raises(InputError, match="maps: expected landmarks on every shape, 0 has none"):
        LandmarkMaps(bases, bare)(0, 4)
    with pytest.raises(InputError, match=r"maps.trusted=61: expected a whole number, 1 to 60"):
        AdjointMaps(bases, mixed, trusted=61)


@pytest.mark.parametrize(
    ("maps", "bound"),
    [(LandmarkMaps, 0.3), (AdjointMaps, 0.3), (partial(KernelMatchingMaps, samples=300), 0.3)],
)
def test_a_collection_without_correspondence_has_nearly_the_operators_of_one_with(maps, bound, shuffled, cache):
    """Five bodies in five poses, two of them shuffled."""
    bodies = list(Bodies(n=5, topology="notoes_collapse5pc"))
    mixed = ShapeList([*bodies[:3], *(shuffled(mesh)[0] for mesh in bodies[3:])])
    back = np.argsort(shuffled(bodies[0])[1])
    marks = farthest_points(bodies[0].vertices, 8)
    mixed.landmarks = [dict(enumerate(marks))] * 3 + [dict(enumerate(back[marks]))] * 2
    sizes = {"k": 40, "size": 20, "keep": 10, "cache": cache}
    area, true = (Pipeline(c, maps=maps, **sizes).operators()[:, 0] for c in (mixed, ShapeList(bodies)))
    spectra, expected = torch.linalg.eigvalsh(area), torch.linalg.eigvalsh(true)
    assert (spectra - expected).norm() < bound * (expected - 1).norm()


def test_landmarks_and_choices_are_in_the_key(mixed):
    def key(maps, marks=True):
        shapes = ShapeList(list(mixed))
        shapes.key, shapes.landmarks = "mixed", mixed.landmarks if marks else ()
        return Pipeline(shapes, k=16, size=10, keep=6, maps=maps).keys["latent"]

    choices = [
        VertexMaps,
        LandmarkMaps,
        partial(LandmarkMaps, landmarks=6),
        AdjointMaps,
        KernelMatchingMaps,
        SplineMaps,
    ]
    keys = [key(maps) for maps in choices] + [key(LandmarkMaps, marks=False)]
    assert len(set(keys)) == len(keys)


def test_a_choice_left_out_is_the_default_to_the_cache_and_to_the_command_line(mixed):
    sizes = {"k": 20, "size": 10, "keep": 8}
    plain, said = (
        Pipeline(mixed, maps=some, **sizes).described_maps
        for some in (RegistrationMaps, partial(RegistrationMaps, functions=80, correspondence="auto", rounds=12))
    )
    assert plain == said == ["lssd_learn.maps.computed.RegistrationMaps", RegistrationMaps.defaults(), 2]
    assert Pipeline(mixed, maps=partial(RegistrationMaps, rounds=3), **sizes).described_maps != plain
    names = ["bases", "collection", "landmarks", "correspondence", "functions", "refined", "commutativity"]
    assert list(signature(LandmarkMaps).parameters) == names
    assert signature(LandmarkMaps).parameters["refined"].annotation == int | None
    with pytest.raises(TypeError, match="round"):
        RegistrationMaps([], mixed, round=3)


@pytest.mark.parametrize("file", sorted(CONF.glob("*.yaml")), ids=lambda file: file.stem)
def test_the_yaml_says_every_choice_and_its_default(file):
    given = OmegaConf.to_container(OmegaConf.load(file))
    kind = getattr(every_map, given.pop("_target_").rpartition(".")[2])
    assert given.pop("_partial_")
    assert given == (kind.defaults() if issubclass(kind, ComputedMaps) else {})


@pytest.mark.parametrize(
    ("kind", "choice", "message"),
    [
        (AutoMaps, {"trusted": 2}, "maps.trusted=2: expected a number from 0 to 1"),
        (AutoMaps, {"correspondence": "all"}, "maps.correspondence=all: expected auto or none"),
        (AdjointMaps, {"functions": 0}, "maps.functions=0: expected a whole number"),
        (AdjointMaps, {"landmarks": 0, "trusted": 99}, "maps.trusted=99: expected a whole number, 1 to 60"),
    ],
)
def test_wrong_choices_are_refused_before_any_eigenbasis(mixed, monkeypatch, kind, choice, message):
    monkeypatch.setattr(sys.modules["lssd_learn.collections.eigenbases"], "in_parallel", None)
    with pytest.raises(InputError, match=message):
        _ = Pipeline(mixed, 12, maps=partial(kind, **choice), size=8, keep=8, cache=None).bases
