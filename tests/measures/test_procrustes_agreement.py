"""`task=procrustes_agreement` through the configuration."""

import csv

import pytest

from lssd_learn.errors import InputError

SMALL = ("task=procrustes_agreement", "basis.k=30", "latent.size=28", "latent.keep=24", "parallel.workers=1")


def test_faces_differ_to_operators_as_they_do_to_landmarks(runs_of, tmp_path):
    found = runs_of(*SMALL)("collection=faces", "collection.identities=3", "task.permutations=99")
    assert found["area/shape/mantel"] > 0.3
    assert found["area/shape/p"] < 0.1
    with (tmp_path / "agreement.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [row["landmarks"] for row in rows] == ["size and shape", "shape"]
    assert rows[0]["shapes"] == "6"


def test_shapes_without_landmarks(runs_of):
    with pytest.raises(InputError, match="landmarks"):
        runs_of(*SMALL)("collection=bodies_small")
