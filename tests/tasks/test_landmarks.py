"""`task=landmarks` on spheres with bumps of one connectivity, through the configuration: no map has to be computed."""

import csv
import logging

import numpy as np
import pytest

from lssd_learn.collections import Bumps, Folder
from lssd_learn.errors import InputError
from lssd_learn.shapes import PointCloud, save

HEIGHTS = [(0.5, 0.1), (0.4, 0.2), (0.3, 0.3), (0.2, 0.4), (0.1, 0.5), (0.3, 0.1)]
MARKS = {"tip": 0, "side": 40, "back": 99}
NAMES = [f"sphere_{i}" for i in range(6)]


@pytest.fixture
def folder(tmp_path):
    """A folder of six spheres, of which the first three have landmarks, a tenth off the surface; one lacks one."""
    place = tmp_path / "bones"
    place.mkdir()
    shapes = Bumps(heights=HEIGHTS, subdivisions=2)
    for name, shape in zip(NAMES, shapes, strict=True):
        save(shape, place / f"{name}.ply")
    _write(place, [(i, label) for i in range(3) for label in MARKS if (i, label) != (2, "tip")])
    return place


def _write(place, which):
    shapes = Bumps(heights=HEIGHTS, subdivisions=2)
    lines = [[NAMES[i], label, *map(str, 1.1 * shapes[i].vertices[MARKS[label]])] for i, label in which]
    (place / "landmarks.csv").write_text("name,landmark,x,y,z\n" + "\n".join(map(",".join, lines)))


@pytest.fixture
def run(runs_of, folder):
    """A function (overrides) → metrics."""
    fixed = ("task=landmarks", "collection=folder", f"collection.path={folder}", "basis.k=30", "latent.size=20")
    return runs_of(*fixed, "latent.keep=10", "parallel.workers=1")


def test_shapes_without_landmarks_get_them(run, folder, tmp_path, caplog):
    with caplog.at_level(logging.INFO):
        found = run()
    assert (found["shapes"], found["landmarks"], found["hubs"], found["left_out"]) == (4, 10, 2, 0)
    with (tmp_path / "landmarks.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [row["origin"] for row in rows].count("given") == 8
    assert len(rows) == 18
    shapes = Bumps(heights=HEIGHTS, subdivisions=2)
    for row in rows:
        shape = shapes[NAMES.index(row["name"])]
        place = np.array([float(row[axis]) for axis in "xyz"])
        vertex = shape.vertices[MARKS[row["landmark"]]]
        near = 1e-6 if row["origin"] == "given" else 0.06
        assert np.linalg.norm(place - 1.1 * vertex) < near
        assert np.linalg.norm(place) > np.linalg.norm(vertex)
    assert any("10 landmarks carried to 4 shapes from 2: sphere_0, sphere_1" in line for line in caplog.messages)
    assert (tmp_path / "markups" / "sphere_5.mrk.json").is_file()
    (folder / "landmarks.csv").write_bytes((tmp_path / "landmarks.csv").read_bytes())  # read as it was written
    assert all(set(Folder(folder).marked(i)) == set(MARKS) for i in range(6))
    assert any("landmarks.csv: 10 of its 18 landmarks were carried over" in line for line in caplog.messages)
    with pytest.raises(InputError, match="all 6 shapes have all 3 landmarks; there is nothing to carry"):
        run()


def test_error_bars_come_with_three_hubs(run, folder, caplog):
    _write(folder, [(i, label) for i in range(4) for label in MARKS])
    found = run("task.most=3", "task.formats=[fcsv,tps]")
    assert found["hubs"] == 3
    assert 0 < found["error_bar"] < 0.1
    assert 0 < found["hub_error"] < 0.1
    assert "tell nothing of errors" not in caplog.text
    run("task.hubs=[sphere_0,sphere_1]")
    assert "2 shapes with landmarks tell nothing of errors; three or more do" in caplog.text


@pytest.mark.parametrize(
    ("overrides", "message"),
    [
        (["task.most=0"], "task.most=0: expected a whole number"),
        (["task.hubs=[nobody]"], "task.hubs: expected names of shapes, got 'nobody'"),
        (["task.hubs=[sphere_5]"], "task.hubs: expected shapes that have landmarks, sphere_5 has none"),
        (["task.formats=[doc]"], "task.formats: expected some of mrk.json, .*, got 'doc'"),
        (["collection.normalise_area=true"], "expected collection.normalise_area=false"),
    ],
)
def test_mistakes(run, overrides, message):
    with pytest.raises(InputError, match=message):
        run(*overrides)


def test_no_landmarks_and_clouds_are_one_line(run, folder):
    save(PointCloud(np.random.default_rng(0).normal(size=(200, 3))), folder / "sphere_7.xyz")
    with pytest.raises(InputError, match="expected meshes, sphere_7 is a cloud"):
        run()
    (folder / "landmarks.csv").unlink()
    with pytest.raises(InputError, match="expected some of the shapes to have landmarks .*, got none"):
        run()
