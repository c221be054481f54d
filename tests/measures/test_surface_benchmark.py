"""`task=surface_benchmark` on a few people of 615 vertices."""

import csv

import pytest

from lssd_learn.errors import InputError

SMALL = ("task=surface_benchmark", "basis.k=40", "latent.size=32", "latent.keep=16")
PEOPLE = ("collection=characters", "collection.characters=15", "collection.poses=[rest]",
          "collection.topology=notoes_collapse5pc", "task.parameters=[height]", "parallel.workers=1")  # fmt: skip


def test_surfaces_are_nearer_to_the_truth_than_the_shape_they_are_drawn_on(runs_of, tmp_path):
    metrics = runs_of(*SMALL)(*PEOPLE)
    assert metrics["parameters/worst"] < 40 < 60 < metrics["parameters/unmoved"]
    assert metrics["components/mean"] < 0.5 * metrics["components/unmoved"]
    with (tmp_path / "surfaces.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [row["along"] for row in rows] == ["height"] * 3 + ["area PC1"] * 2 + ["area PC2"] * 2
    assert (float(rows[0]["value"]), float(rows[2]["value"])) == (0, 1)
    assert (tmp_path / "surfaces.png").stat().st_size > 5000


def test_other_shapes_have_no_truth(runs_of):
    with pytest.raises(InputError, match="expected bodies or characters, or these remeshed"):
        runs_of(*SMALL)("collection=bumps")
    with pytest.raises(InputError, match="task.parameters: expected some of muscle, .* got 'age'"):
        runs_of(*SMALL)(*PEOPLE[:4], "task.parameters=[age]")
