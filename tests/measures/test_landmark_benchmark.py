"""`task=landmark_benchmark` on bodies of one connectivity: no map has to be computed, and the truth is known."""

import csv

import numpy as np
import pytest

from lssd_learn.collections import Bumps
from lssd_learn.collections.turned import Turned
from lssd_learn.errors import InputError
from lssd_learn.shapes import save

MARKS = {"a": 0, "b": 40, "c": 99, "d": 150}


@pytest.fixture
def run(runs_of, tmp_path):
    """A function (overrides) → metrics, on a folder of seven spheres with bumps; the last lacks a landmark."""
    heights = np.random.default_rng(0).uniform(0.1, 0.5, size=(7, 2))
    shapes = Bumps(heights=heights.tolist(), subdivisions=2)
    place, lines = tmp_path / "bones", ["name,landmark,x,y,z"]
    place.mkdir()
    for i, shape in enumerate(shapes):
        save(shape, place / f"s{i}.ply")
        some = [mark for mark in MARKS if (i, mark) != (6, "d")]
        lines += [",".join([f"s{i}", mark, *map(str, 1.05 * shape.vertices[MARKS[mark]])]) for mark in some]
    (place / "landmarks.csv").write_text("\n".join(lines))
    fixed = ("task=landmark_benchmark", "collection=folder", f"collection.path={place}", "basis.k=30")
    return runs_of(*fixed, "latent.size=20", "latent.keep=10", "parallel.workers=1")


def test_known_landmarks_are_found_upright_and_turned(run, tmp_path):
    upright = run("task.hubs=3")
    assert upright["error"] < 0.03
    assert upright["error/3"] == pytest.approx(upright["error"])
    assert upright["error/1"] >= upright["error/3"]
    with (tmp_path / "landmark_errors.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 3 * 4  # of six that have all
    assert np.mean([float(row["error"]) for row in rows]) == pytest.approx(upright["error"], abs=1e-6)
    assert (tmp_path / "landmark_errors.png").is_file()
    turned = run("task.hubs=3", "task.turned=any")
    assert turned["error"] == pytest.approx(upright["error"], rel=1e-3)


def test_random_hubs_are_drawn_several_times_and_some_targets(run, tmp_path):
    run("task.hubs=3", "task.chosen=random", "task.draws=2", "task.targets=2", "task.far=0.001")
    with (tmp_path / "landmark_errors.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [row["draw"] for row in rows] == ["0"] * 8 + ["1"] * 8


@pytest.mark.parametrize(
    ("override", "message"),
    [
        ("task.hubs=6", "task.hubs=6: expected a whole number, 1 to 5"),
        ("task.chosen=best", "task.chosen=best: expected one of shape, random"),
        ("task.turned=upside", "task.turned=upside: expected one of none, any, mirrored"),
        ("task.far=-1", "task.far=-1: expected a number above 0"),
    ],
)
def test_mistakes(run, override, message):
    with pytest.raises(InputError, match=message):
        run(override)


def test_turned_shapes_take_their_landmarks_along():
    base = Bumps(subdivisions=2)
    base.landmarks = [{"a": 5}] * 4
    turned = Turned(base, mirrored=True, seed=3)
    for i, shape in enumerate(turned):
        np.testing.assert_allclose(turned.marked(i)["a"], shape.vertices[5])
        np.testing.assert_allclose(np.linalg.norm(shape.vertices, axis=1), np.linalg.norm(base[i].vertices, axis=1))
        a, b, c = np.moveaxis(shape.vertices[shape.faces], 1, 0)
        assert np.einsum("fx,fx->f", a, np.cross(b, c)).sum() > 0  # outward still
    assert np.linalg.det(turned._motion(1)) < 0 < np.linalg.det(turned._motion(2))
    assert turned.shape_key(0) != Turned(base, seed=4).shape_key(0)
