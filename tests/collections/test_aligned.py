import logging
import pickle

import numpy as np
import pytest
import trimesh
from hydra.utils import instantiate
from omegaconf import OmegaConf
from scipy.spatial.transform import Rotation

from lssd_learn.app import conf
from lssd_learn.cache import Cache
from lssd_learn.collections import Aligned, ShapeList
from lssd_learn.collections.alignment.turns import angles_between
from lssd_learn.errors import InputError
from lssd_learn.shapes import Mesh, save

N = 4


def bone(seed, subdivisions=3):
    """A closed mesh without any symmetry, a little unlike the next."""
    sphere = trimesh.creation.icosphere(subdivisions)
    x, y, z = np.array(sphere.vertices).T
    a, b, c = 1 + 0.08 * np.random.default_rng(seed).normal(size=3)
    radius = 1 + 0.2 * a * np.sin(2 * x + 1) * np.cos(3 * y + 0.5) + 0.15 * b * z * x + 0.2 * c * z
    return Mesh((radius * [x, 1.6 * y, 0.7 * z]).T, sphere.faces)


def poses(n, mirror=True):
    """Turns (n, 3, 3), of which every second mirrors, and shifts."""
    rng = np.random.default_rng(7)
    turn = Rotation.random(n, rng=rng).as_matrix()
    if mirror:
        turn[::2] *= -1
    return turn, rng.normal(size=(n, 3))


def moved(shapes, turns, shifts):
    return ShapeList(
        Mesh(s.vertices @ Q + t, s.faces if np.linalg.det(Q) > 0 else s.faces[:, ::-1])
        for s, Q, t in zip(shapes, turns, shifts, strict=True)
    )


@pytest.fixture(scope="module")
def bones():
    return [bone(seed) for seed in range(N)]


@pytest.fixture(scope="module")
def lain(bones):
    """The bones lying anyhow, laid alike."""
    return Aligned(moved(bones, *poses(N)), cache=None)


def test_shapes_come_to_lie_as_they_were_made(bones, lain):
    turns, _ = poses(N)
    left = turns @ lain.lie.rotation  # of the shapes as made: one turn for all
    assert angles_between(left, left[:1]).max() < 3
    assert len(set(lain.lie.mirrored[::2])) == len(set(lain.lie.mirrored[1::2])) == 1
    aligned = np.stack([shape.vertices for shape in lain])
    made = np.stack([shape.vertices for shape in bones])
    spread = np.linalg.norm(aligned - aligned.mean(axis=0), axis=2).mean()
    assert spread < np.linalg.norm(made - made.mean(axis=0), axis=2).mean() + 0.01


def test_one_shape_stays_as_it_lies(lain):
    still = [i for i in range(N) if lain[i] is lain.collection[i]]
    assert len(still) == 1
    assert lain.lie.mirrored.sum() == 2


def test_a_mirrored_mesh_keeps_its_outside_and_its_vertices(lain):
    for i in np.flatnonzero(lain.lie.mirrored):
        before, after = lain.collection[i], lain[i]
        assert after.connectivity == before.connectivity
        assert after.area == pytest.approx(before.area)
        for shape in (before, after):
            assert trimesh.Trimesh(shape.vertices, shape.faces, process=False).volume > 0


def test_the_order_of_the_shapes_does_not_matter(bones, lain):
    order = [3, 1, 0, 2]
    turns, shifts = poses(N)
    other = Aligned(moved([bones[i] for i in order], turns[order], shifts[order]), cache=None)
    left, there = (turns @ lain.lie.rotation), (turns[order] @ other.lie.rotation)
    np.testing.assert_allclose(angles_between(left[order], there), angles_between(left[order], there)[0], atol=1)
    assert len(set((lain.lie.mirrored[order] == other.lie.mirrored).tolist())) == 1


def test_rows(lain):
    rows = lain.changes()
    assert [row["name"] for row in rows] == list(lain.names)
    assert all(1.5 * row["residual"] < row["residual_other_side"] for row in rows)
    assert {row["mirrored"] for row in rows} == {0, 1}
    assert all(row["of_the_kind"] and not row["partial"] for row in rows)


def test_mirrors_only_where_allowed(bones):
    lain = Aligned(moved(bones[:3], *poses(3)), mirror="forbid", cache=None)
    assert not lain.lie.mirrored.any()


def test_a_shape_of_another_kind_is_named(bones, caplog):
    torus = trimesh.creation.torus(1, 0.3, major_sections=40, minor_sections=20)
    shapes = moved([*bones[:3], Mesh(torus.vertices, torus.faces)], *poses(4, mirror=False))
    with caplog.at_level(logging.WARNING):
        lain = Aligned(shapes, cache=None)
        assert lain.lie.fits.tolist() == [True] * 3 + [False]
    assert "of another kind than most, or badly laid: 3" in caplog.text


def test_spheres_are_a_tie_that_is_named(caplog):
    sphere = trimesh.creation.icosphere(3)
    with caplog.at_level(logging.WARNING):
        lain = Aligned(moved([Mesh(sphere.vertices, sphere.faces)] * 2, *poses(2)), cache=None)
        assert not lain.lie.mirrored.any()
    assert "mirrored they fit as well" in caplog.text
    assert "another turn fits as well" in caplog.text


def test_auto_leaves_what_corresponds_or_lies_alike(bones, caplog):
    with caplog.at_level(logging.INFO):
        same = ShapeList(bones[:2])
        assert Aligned(same, "auto", cache=None)[0] is same[0]
        alike = ShapeList([bones[0], bone(1, subdivisions=4)])
        assert Aligned(alike, "auto", cache=None)[1] is alike[1]
    assert "in vertex correspondence" in caplog.text
    assert "lie alike already" in caplog.text


def test_auto_turns_what_lies_anyhow_and_leaves_what_no_turn_lays(bones, caplog):
    turned = moved([bones[0], bone(1, subdivisions=4)], *poses(2))
    assert any(shape is not own for shape, own in zip(Aligned(turned, "auto", cache=None), turned, strict=True))
    torus = trimesh.creation.torus(1, 0.3, major_sections=40, minor_sections=20)
    unlike = moved([bones[0], Mesh(torus.vertices, torus.faces)], *poses(2))
    with caplog.at_level(logging.WARNING):
        assert all(shape is own for shape, own in zip(Aligned(unlike, "auto", cache=None), unlike, strict=True))
    assert "no turn lays these shapes on each other" in caplog.text


def test_what_is_known_of_shapes_goes_along(bones):
    shapes = ShapeList(bones[:2])
    shapes.key, shapes.landmarks, shapes.up = "two", [{"tip": 3}] * 2, "y"
    shapes.vertex_maps, shapes.groups = {(0, 1): np.arange(3)}, {"kind": np.array(["a", "b"])}
    lain = Aligned(shapes)
    for name in ("names", "landmarks", "up", "vertex_maps", "groups", "parameters", "parts"):
        assert getattr(lain, name) is getattr(shapes, name)
    keys = {Aligned(shapes, *how).key for how in (("rigid",), ("auto",), ("rigid", "forbid"), ("none",))}
    assert len(keys) == 4
    assert Aligned(shapes, "none").key == "two"
    assert Aligned(shapes, "none").shape_key(1) == "two/1"
    assert lain.shape_key(0) != lain.shape_key(1)


def test_what_was_found_is_kept(bones, tmp_path, monkeypatch):
    monkeypatch.setenv("LSSD_CACHE", str(tmp_path))
    shapes = moved(bones[:2], *poses(2))
    shapes.key = "two"
    first = Aligned(shapes, cache=Cache()).lie
    monkeypatch.setattr("lssd_learn.collections.aligned.find", None)
    again = Aligned(shapes, cache=Cache())
    np.testing.assert_array_equal(pickle.loads(pickle.dumps(again)).lie.rotation, first.rotation)


def test_a_folder_from_the_command_line(bones, tmp_path, monkeypatch):
    monkeypatch.delenv("LSSD_CACHE", raising=False)
    for i, shape in enumerate(moved(bones[:2], *poses(2))):
        save(shape, tmp_path / f"{i}.ply")
    cfg = OmegaConf.load(conf() / "collection" / "folder.yaml")
    cfg.path = str(tmp_path)
    np.testing.assert_array_equal(instantiate(cfg).lie.rotation, np.stack([np.eye(3)] * 2))
    cfg.align = "rigid"
    lain = instantiate(cfg)
    lain.keep_in(Cache(tmp_path / "cache"))
    assert lain.lie.mirrored.sum() == 1
    assert (tmp_path / "cache" / "aligned").is_dir()


@pytest.mark.parametrize(("how", "message"), [
    ({"align": "yes"}, "collection.align=yes: expected one of none, rigid, auto"),
    ({"mirror": "yes"}, "collection.mirror=yes: expected one of auto, forbid, allow"),
])  # fmt: skip
def test_errors(bones, how, message):
    with pytest.raises(InputError, match=message):
        Aligned(bones, **how)
