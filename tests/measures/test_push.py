"""`task=push`: what a latent space of some shapes is worth to all."""

import csv
import logging
from types import SimpleNamespace

import numpy as np
import pytest

from lssd_learn.collections import ShapeList
from lssd_learn.errors import InputError
from lssd_learn.measures.push import run
from lssd_learn.pipeline import Pipeline

WAYS = [(way, change) for way in ("least_squares", "nearest") for change in ("orthogonal", "normalised")]


@pytest.fixture
def pieces(deformed_spheres):
    """A function (fitted, n) → pieces of n deformed spheres, some of which make the latent space.

    Functions of a sphere come in clusters of 1, 3, 5, 7, and a space must not end within one.
    """

    def make(fitted, n=30):
        pipeline = Pipeline(ShapeList(deformed_spheres(n, 2)), k=25, size=16, keep=9, fitted=fitted, cache=None)
        return SimpleNamespace(pipeline=pipeline, operators=["area", "conformal"])

    return make


def test_pushed_shapes_come_near_to_where_a_fit_would_put_them(pieces, tmp_path, caplog):
    with caplog.at_level(logging.INFO):
        metrics = run(pieces(range(0, 30, 2)), tmp_path)
    assert (metrics["shapes"], metrics["fitted"]) == (30, 15)
    for way, change in WAYS:
        for who in ("fitted", "pushed"):
            mean, worst = (metrics[f"{way}/{change}/{who}/{what}"] for what in ("mean", "worst"))
            assert 0 < mean <= worst < 1
        assert metrics[f"{way}/normalised/pushed/mean"] < metrics[f"{way}/orthogonal/pushed/mean"] / 3
    assert metrics["least_squares/normalised/pushed/mean"] < metrics["nearest/normalised/pushed/mean"] < 0.2
    for lap in ("all", "some", "least_squares", "nearest"):
        assert metrics[f"seconds/{lap}"] > 0
        assert metrics[f"cpu_seconds/{lap}"] >= 0
    with (tmp_path / "push.csv").open(encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    assert [row["fitted"] for row in rows] == ["1", "0"] * 15
    pushed = [float(row["nearest_normalised"]) for row in rows[1::2]]
    assert np.mean(pushed) == pytest.approx(metrics["nearest/normalised/pushed/mean"], rel=1e-4)
    assert "15 shapes fitted, 15 pushed" in caplog.text


def test_a_space_of_nearly_all_shapes_is_nearly_that_of_all(pieces, tmp_path):
    most, half = (run(pieces(fitted), tmp_path) for fitted in (range(29), range(15)))
    for way, change in WAYS[:2]:
        for key in (f"{way}/{change}/{who}/mean" for who in ("fitted", "pushed")):
            assert most[key] < half[key]


def test_nothing_to_push(pieces, tmp_path):
    for fitted in (None, range(6)):
        with pytest.raises(InputError, match="task=push: expected latent.fitted=…, less than all shapes"):
            run(pieces(fitted, 6), tmp_path)
    with pytest.raises(InputError, match="task.neighbours=0"):
        run(pieces([0, 1], 6), tmp_path, neighbours=0)


def test_a_topology_by_groups_gets_the_labels_of_those_fitted(runs_of):
    run = runs_of("collection=bodies_small", "collection.n=16", "collection.topology=notoes_collapse5pc", "basis.k=20",
                  "latent.size=16", "latent.keep=10", "latent.fitted=12", "parallel.workers=1")  # fmt: skip
    assert run("task=push", "network=clusters")["fitted"] == 12
