"""`task=baselines` on small bodies and on shapes without common faces, through the configuration."""

import csv
import logging

import numpy as np
import pytest

from lssd_learn.errors import InputError
from lssd_learn.learning import mean_reference, operator_features, ridge_reference
from lssd_learn.shapes import save
from lssd_learn.studies.baselines import WORDS
from lssd_learn.sweeps.runs import Run
from lssd_learn.sweeps.table import Group, Table
from lssd_learn.tasks.training import plan

SMALL = ("task=baselines", "collection=bodies_small", "basis.k=20", "latent.size=16", "latent.keep=10")
FOLDER = ("collection=folder", "basis.k=10", "latent.size=8", "latent.keep=6")
CORRESPONDENCE = {"vertices", "edge_lengths", "vertex_areas"}


@pytest.fixture
def pieces(pieces_of, tmp_path, common_cache, monkeypatch):
    """A function (overrides) → the pieces of a run; what a run leaves lies in `tmp_path`."""
    monkeypatch.setenv("LSSD_CACHE", str(common_cache))

    def make(*overrides):
        return pieces_of(tmp_path, *SMALL, *overrides)

    return make


@pytest.fixture
def folder(small_mesh_folder, deformed_spheres):
    """A folder of twelve labelled spheres, the first five with the same faces, the others with those of none."""
    for i, mesh in enumerate(deformed_spheres(12, 2)):
        save(mesh, small_mesh_folder / f"shape_{i:02d}.ply")
    for path in small_mesh_folder.glob("shape_?.ply"):
        path.unlink()
    rows = [f"shape_{i:02d},{x}\n" for i, x in enumerate(np.random.default_rng(0).random(12))]
    (small_mesh_folder / "labels.csv").write_text("name,width\n" + "".join(rows))
    return small_mesh_folder


def names(metrics):
    return [name.split("/")[1] for name in metrics if name.endswith("/l1")]


def test_every_baseline_is_scored_on_the_split_of_a_regression(pieces, tmp_path, caplog):
    given = pieces()
    with caplog.at_level(logging.INFO):
        metrics = given.task(given, tmp_path)
    assert names(metrics) == list(WORDS)
    assert set(metrics) == {f"reference/{name}/{key}" for name in WORDS for key in ("mse", "l1", "validation/mse")}
    assert np.isfinite(list(metrics.values())).all()

    parameters, (parts, _) = given.pipeline.collection.parameters, plan(given, 1)
    mean = mean_reference(parameters, parts)
    area = ridge_reference(operator_features(given.pipeline.operators()), parameters, parts)
    assert (metrics["reference/mean/mse"], metrics["reference/mean/l1"]) == pytest.approx((mean.mse, mean.l1))
    assert (metrics["reference/area/mse"], metrics["reference/area/l1"]) == pytest.approx((area.mse, area.l1))

    with (tmp_path / "bases.csv").open() as stream:
        rows = {row["base"]: row for row in csv.DictReader(stream)}
    assert list(rows) == [given.pipeline.collection.names[i] for i in parts.train]
    for kind in ("area", "operators"):
        found = [float(row[f"{kind}/validation/mse"]) for row in rows.values()]
        for word, wanted in (("best", min(found)), ("worst", max(found))):
            assert metrics[f"reference/base_{kind}_{word}/validation/mse"] == wanted
    table = caplog.text[caplog.text.index("of ridge regression on:") :]
    assert all(words in table for words in WORDS.values())


def test_the_first_columns_of_a_summary_are_test_errors(pieces, tmp_path):
    given = pieces("task.bases=2")
    table = Table([], [Group({}, [Run("0", {}, given.task(given, tmp_path), None)], 0)], [])
    assert [name.split("/")[2] for name in table.chosen] == ["mse"] * 8


def test_some_base_shapes_are_spread_over_the_training_split(pieces, tmp_path):
    given = pieces("task.bases=3")
    given.task(given, tmp_path)
    with (tmp_path / "bases.csv").open() as stream:
        rows = list(csv.DictReader(stream))
    train = plan(given, 1)[0].train
    assert [row["base"] for row in rows] == [given.pipeline.collection.names[train[i]] for i in (0, 14, 29)]


@pytest.mark.parametrize("protocol", [("inductive",), ("held_out_pose", "data.held_out=sitting")])
def test_only_training_shapes_are_bases_whatever_the_protocol(pieces, tmp_path, protocol):
    given = pieces(f"data.protocol={protocol[0]}", *protocol[1:])
    metrics = given.task(given, tmp_path)
    assert names(metrics) == list(WORDS)
    with (tmp_path / "bases.csv").open() as stream:
        rows = [row["base"] for row in csv.DictReader(stream)]
    assert rows == [given.pipeline.collection.names[i] for i in plan(given, 1)[0].train]


def test_shapes_without_common_faces_do_with_their_maps(pieces, folder, tmp_path, caplog):
    """Maps from the first shape and back alone: it is the one base shape, if any."""
    for i in range(1, 12):
        for a, b in ((0, i), (i, 0)):
            file = folder / "maps" / f"shape_{a:02d}__shape_{b:02d}.txt"
            file.parent.mkdir(exist_ok=True)
            file.write_text("\n".join(map(str, range(162))))
    how = ("collection.correspondence=none", "maps=correspondence", "network=star")
    given = pieces(*FOLDER, f"collection.path={folder}", *how)
    with caplog.at_level(logging.INFO):
        metrics = given.task(given, tmp_path)
    train = plan(given, 1)[0].train
    reached = 0 in train
    bases = {name for name in WORDS if name.startswith("base_")}
    assert set(names(metrics)) == set(WORDS) - CORRESPONDENCE - (set() if reached else bases)
    assert "left out: the shapes are not all in vertex correspondence" in caplog.text
    lost = len(train) - reached
    assert f"{lost} of {len(train)} base shapes left out, for want of maps: maps: shape_" in caplog.text


def test_a_folder_in_correspondence_has_them_all(pieces, folder, tmp_path):
    given = pieces(*FOLDER, f"collection.path={folder}")
    assert names(given.task(given, tmp_path)) == list(WORDS)


def test_mistakes_are_told(pieces, folder, tmp_path, monkeypatch):
    monkeypatch.setenv("LSSD_CACHE", str(tmp_path / "cache"))
    (folder / "labels.csv").unlink()
    given = pieces(*FOLDER, f"collection.path={folder}")
    with pytest.raises(InputError, match="task=baselines: expected shapes with parameters; this collection has none"):
        given.task(given, tmp_path)
    given = pieces("task.bases=31")
    with pytest.raises(InputError, match=r"task.bases=31: expected a whole number, 1 to 30"):
        given.task(given, tmp_path)
    assert not (tmp_path / "cache" / "eigenbasis").exists()
