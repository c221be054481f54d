"""`task=classification` on stretched and unstretched spheres, through the configuration."""

import logging

import numpy as np
import pytest
from hydra import compose, initialize_config_dir
from hydra.utils import instantiate
from omegaconf import OmegaConf

from lssd_learn.app import conf
from lssd_learn.collections import ShapeList
from lssd_learn.errors import InputError
from lssd_learn.learning.checkpoint import read
from lssd_learn.shapes import Mesh, save
from lssd_learn.tasks.classification import choose_group, encode
from lssd_learn.tasks.pieces import Pieces

SMALL = (
    "task=classification", "collection=folder", "basis.k=10", "latent.size=8", "latent.keep=6",
    "task.epochs=60", "data.batch=8", "data.points=64",
)  # fmt: skip


@pytest.fixture
def classify(deformed_spheres, tmp_path, monkeypatch):
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
        with initialize_config_dir(str(conf()), version_base="1.3"):
            config = compose("config", overrides=[*SMALL, f"collection.path={folder}", *overrides])
        choices = {"collection": "folder", "network": "clique", "net": "mlp"}
        pieces = Pieces.from_config(OmegaConf.to_container(config, resolve=True), choices, instantiate, tmp_path, "")
        return pieces.task(pieces, tmp_path)

    return run


def test_the_group_of_a_folder_is_learnt(classify, tmp_path):
    metrics = classify(["round", "long", "round", "long"] * 10, "net=mlp", "task.milestones=[5]")
    assert next(iter(metrics)) == "test/accuracy"
    assert metrics["test/accuracy"] == metrics["reference/linear/accuracy"] == 1
    assert 0 < metrics["reference/majority/accuracy"] < 1
    assert 0 <= metrics["test/accuracy@5"] <= 1
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


@pytest.mark.parametrize("group", [None, "parity"])
def test_a_group_is_chosen(group):
    shapes = ShapeList([])
    with pytest.raises(InputError, match="expected shapes with groups; this collection has none"):
        choose_group(shapes, group)
    shapes.groups = {"parity": np.arange(2)}
    assert choose_group(shapes, group) == "parity"
    shapes.groups = {"parity": np.arange(2), "2024": np.arange(2)}
    assert choose_group(shapes, 2024) == "2024"
    with pytest.raises(InputError, match="task.group: expected one of parity, 2024"):
        choose_group(shapes)
    with pytest.raises(InputError, match="task.group=half: expected one of parity, 2024"):
        choose_group(shapes, "half")


@pytest.mark.parametrize(
    ("labels", "classes", "places"),
    [
        ([7, -1, 7], [-1, 7], [1, 0, 1]),
        (["b", "a", "b"], ["a", "b"], [1, 0, 1]),
        (np.array(["x", 2], dtype=object), ["2", "x"], [1, 0]),
        ([True, False], ["False", "True"], [1, 0]),
    ],
)
def test_classes_are_plain_values_in_order(labels, classes, places):
    found, indices = encode(labels)
    assert found == classes
    assert [type(c) for c in found] == [type(c) for c in classes]
    assert (indices.tolist(), indices.dtype) == (places, np.int64)
