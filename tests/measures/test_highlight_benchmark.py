"""`task=highlight_benchmark` on bodies of 615 vertices, through the configuration."""

import csv

import pytest
from pictures import coloured

from lssd_learn.errors import InputError
from lssd_learn.measures.highlight_benchmark import ANSWERS
from lssd_learn.view import highlights

SMALL = ("task=highlight_benchmark", "basis.k=50", "latent.size=45", "latent.keep=45", "parallel.workers=1")


@pytest.fixture
def run(runs_of, monkeypatch):
    """A function (overrides) → metrics."""
    monkeypatch.setattr(highlights, "LARGEST", 60)
    return runs_of(*SMALL)


def test_what_is_highlighted_is_where_the_bodies_differ(run, tmp_path):
    metrics = run("collection=changed", "collection.change=hips", "collection.topology=notoes_collapse5pc")
    assert metrics["auc"] > 0.97
    assert metrics["auc"] == metrics["area/all, at each vertex/auc"] > metrics["area/first function/auc"]
    assert 0.5 < metrics["auc/lowest"] <= metrics["auc"]
    assert metrics["pearson"] > 0.8
    with (tmp_path / "highlights.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [row["answer"] for row in rows] == list(ANSWERS)
    assert (rows[0]["change"], rows[0]["others"], rows[0]["n"], rows[0]["keep"]) == ("hips", "middle", "8", "45")
    assert float(rows[4]["auc"]) == pytest.approx(metrics["auc"], abs=1e-4)
    assert coloured(tmp_path / "highlighted.png") > 0.008  # .013 here


def test_a_collection_without_a_truth(run):
    with pytest.raises(InputError, match="expected collection=changed"):
        run("collection=bodies_small")
