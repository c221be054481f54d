"""`task=gram_quality`: shapes that the space was not fitted to, from their Gram forms."""

import csv
from types import SimpleNamespace

import numpy as np
import pytest

from lssd_learn.collections import Bodies, ShapeList
from lssd_learn.division.protocols import Division, divide
from lssd_learn.errors import InputError
from lssd_learn.measures.gram_quality import WAYS, run
from lssd_learn.pipeline import Pipeline
from lssd_learn.shapes import Mesh


@pytest.fixture
def pieces(deformed_spheres):
    """A function fitted → pieces of twelve deformed spheres, of which these make the latent space."""
    meshes = deformed_spheres(12, 2)
    pattern = 0.1 * np.sin(9 * np.mean([mesh.vertices for mesh in meshes], axis=0))  # what they share is their detail
    shapes = ShapeList(Mesh(mesh.vertices + pattern, mesh.faces) for mesh in meshes)

    def made(fitted, protocol="transductive"):
        pipeline = Pipeline(shapes, k=25, size=25, keep=16, fitted=fitted, cache=None)
        return SimpleNamespace(pipeline=pipeline, seed=0, data=Division(protocol=protocol))

    return made


def test_detail_helps_and_the_table_says_the_same(pieces, tmp_path):
    metrics = run(pieces(range(8)), tmp_path)
    assert (metrics["shapes"], metrics["fitted"]) == (4, 8)
    assert metrics["detailed/mean"] < min(metrics[f"{way}/mean"] for way in ("mean", "nearest", "smooth"))
    with (tmp_path / "gram_quality.csv").open(encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    for way in WAYS:
        values = [float(row[way]) for row in rows]
        assert sum(values) / 4 == pytest.approx(metrics[f"{way}/mean"], rel=1e-4)
        assert max(values) == pytest.approx(metrics[f"{way}/worst"], rel=1e-4)


def test_of_a_protocol_its_test_is_drawn(pieces, tmp_path):
    shapes = pieces(None).pipeline.collection
    parts = divide(shapes, 0, Division())
    metrics = run(pieces(parts.train, "inductive"), tmp_path)
    assert (metrics["shapes"], metrics["fitted"]) == (2, 9)
    with (tmp_path / "gram_quality.csv").open(encoding="utf-8") as stream:
        assert [row["name"] for row in csv.DictReader(stream)] == [shapes.names[i] for i in parts.test]


def test_nothing_to_draw(pieces, tmp_path):
    with pytest.raises(InputError, match="^task=gram_quality: expected latent.fitted=…, less than all shapes"):
        run(pieces(None), tmp_path)


def test_analogies_of_bodies(tmp_path):
    bodies = Bodies(n=20, topology="notoes_collapse3pc", poses="eight_and_free")
    pipeline = Pipeline(bodies, k=40, size=30, keep=24, fitted=range(16), cache=None, workers=1)
    metrics = run(SimpleNamespace(pipeline=pipeline, seed=0, data=Division()), tmp_path, analogies=3)
    assert metrics["analogy/mean"] < 0.5 * metrics["analogy/C"]
    assert metrics["analogy/own"] < metrics["analogy/mean"]
    assert metrics["analogy/exact"] < metrics["analogy/mean"]


def test_analogies_of_others(pieces, tmp_path):
    with pytest.raises(InputError, match="^task.analogies=3: expected collection=bodies without jitter"):
        run(pieces(range(8)), tmp_path, analogies=3)
