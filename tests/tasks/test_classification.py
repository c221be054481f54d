"""`task=classification` on stretched and unstretched spheres, through the configuration."""

import logging

import numpy as np
import pytest

from lssd_learn.learning import split
from lssd_learn.learning.checkpoint import read
from lssd_learn.shapes import Mesh, save

SMALL = (
    "task=classification", "collection=folder", "basis.k=10", "latent.size=8", "latent.keep=6",
    "task.epochs=60", "data.batch=8", "data.points=64",
)  # fmt: skip


@pytest.fixture
def classify(pieces_of, deformed_spheres, tmp_path, monkeypatch):
    """A function (labels, overrides) → metrics; sphere i is stretched where its label is not that of sphere 0."""
    monkeypatch.setenv("LSSD_CACHE", str(tmp_path / "cache"))
    folder = tmp_path / "shapes"
    folder.mkdir()

    def run(labels, *overrides):
        for i, mesh in enumerate(deformed_spheres(len(labels), 1)):
            stretch = [1, 1, 1 + 2 * (labels[i] != labels[0])]
            save(Mesh(mesh.vertices * stretch, mesh.faces), folder / f"s{i:02d}.ply")
        rows = [f"s{i:02d},{label}\n" for i, label in enumerate(labels)]
        (folder / "labels.csv").write_text("name,kind\n" + "".join(rows))
        pieces = pieces_of(tmp_path, *SMALL, f"collection.path={folder}", *overrides, collection="folder", net="mlp")
        return pieces.task(pieces, tmp_path)

    return run


def test_the_group_of_a_folder_is_learnt(classify, tmp_path):
    metrics = classify(["round", "long", "round", "long"] * 10, "net=mlp", "task.milestones=[5]")
    assert next(iter(metrics)) == "test/accuracy"
    assert metrics["test/accuracy"] == metrics["reference/linear/accuracy"] == 1
    parts = split(40, 0)
    is_long = np.tile([False, True], 20)
    majority = is_long[parts.train].sum() > len(parts.train) / 2  # of two as frequent, the first: long
    majority |= is_long[parts.train].sum() * 2 == len(parts.train)
    assert metrics["reference/majority/accuracy"] == pytest.approx((is_long[parts.test] == majority).mean())
    right = metrics["test/accuracy@5"] * len(parts.test)
    assert right == pytest.approx(round(right), abs=1e-4)
    checkpoint = read(tmp_path / "best.ckpt")
    assert (checkpoint["group"], checkpoint["classes"]) == ("kind", ["long", "round"])
    assert "latent" in checkpoint


def test_numbers_are_classes_too_and_clouds_inputs(classify, tmp_path):
    metrics = classify([3, 10] * 10, "net=pointnet", "collection.groups=[kind]", "task.group=kind", "task.epochs=2")
    assert np.isfinite(metrics["test/cross_entropy"])
    assert read(tmp_path / "best.ckpt")["classes"] == ["10", "3"]


def test_a_class_that_is_not_in_the_training_split_is_told(classify, caplog):
    with caplog.at_level(logging.WARNING):
        classify(["a"] * 19 + ["b"], "net=mlp", "task.epochs=1", "debug=overfit", "debug.epochs=1")
    assert "kind: the training split has no shape of 'b', so no net can learn it" in caplog.text
