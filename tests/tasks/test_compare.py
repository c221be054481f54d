"""`task=compare` and `task=embed` on spheres with bumps, through the configuration."""

import csv
import logging

import numpy as np
import pytest
import trimesh
from pictures import coloured
from tensorboard.backend.event_processing.event_accumulator import EventAccumulator

from lssd_learn.errors import InputError
from lssd_learn.view import highlights

SMALL = ("collection=bumps", "collection.subdivisions=3", "basis.k=40", "latent.size=32", "latent.keep=24",
         "parallel.workers=1")  # fmt: skip


@pytest.fixture
def run(runs_of, monkeypatch):
    """A function (overrides) → metrics of a task on the four spheres."""
    monkeypatch.setattr(highlights, "LARGEST", 100)  # small pictures are quick ones
    return runs_of(*SMALL)


def test_a_comparison_leaves_what_it_promises(run, tmp_path, caplog):
    with caplog.at_level(logging.INFO):
        metrics = run("task=compare", "latent.operators=[area,conformal]", "task.permutations=9")
    assert (metrics["shapes"], metrics["labelled"]) == (4, 4)
    assert all(np.isfinite(value) for value in metrics.values())
    assert metrics["area/accuracy/before"] == 0  # the bump on the side is what shapes vary most by
    assert metrics["area/accuracy/after"] == 1
    assert metrics["area/silhouette/after"] > 0.8 > 0 > metrics["area/silhouette/before"]
    assert metrics["area/size/A"] < 1 < metrics["area/size/B"]
    assert metrics["area/stability"] > 0.99
    for name, least in (("highlighted.png", 0.04), ("embedding.png", 0.0006)):  # .066 and .0012 here
        assert coloured(tmp_path / name) > least
    assert 1e5 < (tmp_path / "report.html").stat().st_size < 15e6
    text = (tmp_path / "report.html").read_text()
    assert '<td style="background:rgba(59,76,192,0.65);color:#fff">2</td>' in text  # all are told right
    assert {file.name for file in (tmp_path / "surfaces").iterdir()} == {
        f"{name}{suffix}" for name in ("mean", "set_A-B_low", "set_A-B_high") for suffix in (".ply", ".glb")
    }
    names = {f"{kind}_{name}" for kind in ("area", "conformal") for name in
             ("region", "function1", "function2", "global")}  # fmt: skip
    files = {f"sphere_{i:02d}_{name}{suffix}" for i in range(4) for name in names for suffix in (".ply", ".glb")}
    files |= {f"sphere_{i:02d}.vtp" for i in range(4)}
    assert {file.name for file in (tmp_path / "shapes").iterdir()} == files
    text = (tmp_path / "shapes/sphere_00.vtp").read_text()
    assert all(f'type="Float64" Name="{name}"' in text for name in names)
    events = EventAccumulator(str(tmp_path / "tensorboard"))
    events.Reload()
    assert set(events.Tags()["images"]) == {"compare/highlighted", "compare/embedding"}
    assert {f"highlighted/{name}_COLOR" for name in names} <= set(events.Tags()["tensors"])
    assert any("permutation test, p" in line and line.count("0.") == 2 for line in caplog.messages)
    assert "report.html" in caplog.messages[-1]


def test_the_region_is_red_on_top_of_every_sphere(run, tmp_path):
    run("task=compare", "task.permutations=9", "task.count=1")
    for i in range(4):
        mesh = trimesh.load(tmp_path / f"shapes/sphere_{i:02d}_area_region.ply", process=False)
        colours = np.asarray(mesh.visual.vertex_colors)[:, :3].astype(int)
        red = colours[:, 0] - colours[:, 2] > 100
        assert mesh.vertices[red, 2].min() > 0.6  # the bump ends at cos 40° = .77
        assert red.any()


def test_some_labels_of_a_grouping(run):
    metrics = run("task=compare", "task.permutations=9", "collection.groups.set=[1,2,2,1]",
                  "task.group=set", "task.labels=[2,1]", "task.shown=1", "task.method=ratio")  # fmt: skip
    assert [name for name in metrics if "/size/" in name] == ["area/size/2", "area/size/1"]


@pytest.mark.parametrize(
    ("overrides", "message"),
    [
        (["task.group=kind"], "task.group=kind: expected one of set"),
        (["task.labels=[A,C]"], r"task.labels=\[A,C\]: set has no label 'C'; it has A, B"),
        (["task.method=best"], "task.method=best: expected one of difference, ratio"),
        (["task.count=25"], "task.count=25: expected a whole number, 1 to 24"),
        (["task.shown=0"], "task.shown=0: expected a whole number, 1 or more"),
        (["task.few=0"], "task.few=0: expected a whole number, 1 or more"),
        (["task.permutations=0"], "task.permutations=0: expected a whole number, 1 or more"),
    ],
)
def test_mistakes(run, overrides, message):
    with pytest.raises(InputError, match=message):
        run("task=compare", *overrides)


def test_an_embedding_is_a_picture_and_a_table(run, tmp_path):
    metrics = run("task=embed", "latent.operators=[area,conformal]", "task.dimensions=3", "network=chain",
                  "task.base=1")  # fmt: skip
    assert metrics["shapes"] == 4
    assert abs(metrics["area/turns"]) <= 1.5
    assert metrics["area/smallest_step"] <= 180 * metrics["area/turns"]
    # Seen from the sphere with the bump on the side, the same varies most.
    assert metrics["base_area/1"] > 0.5
    assert (tmp_path / "shapes.png").stat().st_size > 5000
    assert (tmp_path / "components.png").stat().st_size > 5000
    assert (tmp_path / "surfaces" / "conformal_PC3_high.glb").stat().st_size > 1000
    assert metrics["area/1"] > 0.5 > metrics["area/2"] > metrics["area/3"]
    with (tmp_path / "embedding.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert list(rows[0]) == [
        "name",
        "set",
        *(f"{kind}_{d}" for kind in ("area", "conformal", "base_area", "base_conformal") for d in (1, 2, 3)),
    ]
    assert [(row["name"], row["set"]) for row in rows[1:3]] == [("sphere_01", "A"), ("sphere_02", "B")]
    side = np.array([float(row["area_1"]) for row in rows])
    assert np.sign(side).tolist() in ([1, -1, 1, -1], [-1, 1, -1, 1])  # with and without the bump on the side
    assert (tmp_path / "embedding.png").stat().st_size > 5000


def test_a_base_that_is_not_there(run):
    with pytest.raises(InputError, match="task.base=4: expected a whole number, 0 to 3"):
        run("task=embed", "task.base=4")


PEOPLE = ("collection=characters", "collection.characters=4", "collection.topology=notoes_collapse5pc", "basis.k=30",
          "latent.size=20", "latent.keep=12", "collection.poses=[rest,sitting]", "parallel.workers=1")  # fmt: skip


def test_two_poses_of_the_same_people(runs_of, monkeypatch, caplog):
    monkeypatch.setattr(highlights, "LARGEST", 100)
    with caplog.at_level(logging.INFO):
        found = runs_of(*PEOPLE)("task=compare", "task.group=pose", "task.blocks=character")
    assert found["area/p_value/smallest"] == 2 / 16
    assert all(np.isfinite(value) for value in found.values())
    assert found["area/stability"] > 0.3  # people differ more than poses, and yet there is a field
    assert "blocks by character: 4 blocks with several groups permuted within" in caplog.messages
    assert any("smallest p there could be" in line for line in caplog.messages)


@pytest.mark.parametrize(
    ("overrides", "message"),
    [
        (["task.group=pose", "task.blocks=person"], "task.blocks=person: expected one of character, pose"),
        (["task.group=pose", "task.blocks=pose"], "task.blocks=pose: expected two blocks or more with shapes of each"),
    ],
)
def test_blocks_that_do_not_do(runs_of, overrides, message):
    with pytest.raises(InputError, match=message):
        runs_of(*PEOPLE)("task=compare", *overrides)
