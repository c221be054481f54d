"""`task=align` on small bodies, through the configuration."""

import csv
import logging

import numpy as np
import pytest
from PIL import Image

from lssd_learn.errors import InputError
from lssd_learn.tasks.align import _Bases

SMALL = ("experiment=paper_alignment", "collection.topology=notoes_collapse5pc", "basis.k=40", "latent.size=32",
         "latent.keep=20", "collection.poses=[rest,t_pose,sitting,bend]", "parallel.workers=1")  # fmt: skip


@pytest.fixture
def run(runs_of):
    """A function (overrides) → metrics."""
    return runs_of(*SMALL)


def test_two_people_find_each_others_poses(run, tmp_path, caplog):
    with caplog.at_level(logging.INFO):
        found = run()
    assert (found["pairs"], found["right"], found["chance"]) == (4, 1, 0.25)
    assert 0 <= found["bases/failed_same"] <= 1
    assert 0.25 < found["bases/right"] <= 1 - found["bases/failed"] / 4
    with (tmp_path / "alignment.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [(row["name"], row["partner"], row["right"]) for row in rows] == [
        (f"character_00_{pose}", f"character_01_{pose}", "1") for pose in ("rest", "t_pose", "sitting", "bend")
    ]
    assert np.asarray(Image.open(tmp_path / "alignment.png").convert("L")).std() > 5
    assert "4 of 4 pairs are right" in caplog.messages
    assert any(line.startswith("base-shape differences: ") for line in caplog.messages)
    assert "alignment.csv, alignment.png" in caplog.messages[-1]


def test_without_a_truth_it_just_pairs(run, tmp_path):
    found = run("task.truth=null", "task.bases=false", "network=chain")
    assert set(found) == {"pairs", "alone", "cost"}
    assert (tmp_path / "alignment.csv").read_text().splitlines()[0] == "name,partner,cost"


def test_a_pose_may_stay_alone(run, tmp_path):
    strict = run("task.unmatched=0.01", "task.bases=false")
    rows = (tmp_path / "alignment.csv").read_text().splitlines()
    assert strict["alone"] == 4 - strict["pairs"] > 0
    assert sum(row.split(",")[1] == "" for row in rows[1:]) == strict["alone"]
    assert run("task.unmatched=10", "task.bases=false")["alone"] == 0


def test_right_pairs_are_counted_for_each_pair_of_bases():
    bases = _Bases(np.array([[[0, 1], [1, 0]], [[0, 1], [0, 2]]]))
    np.testing.assert_array_equal(bases.right(np.array([0, 1])), [[1, 0], [1, 0.5]])


def test_a_sparse_network_is_aligned_by_composed_maps(run):
    found = run("network=spanning_tree", "task.bases=true")
    assert found["right"] == 1


@pytest.mark.parametrize(
    ("overrides", "message"),
    [
        (["task.unmatched=-1"], "task.unmatched=-1: expected a number above 0"),
        (["task.group=null"], "task.group: expected one of character, pose"),
        (["task.group=pose"], "task.labels: expected two groups to align, pose has 4"),
        (["task.truth=sex"], "task.truth=sex: expected a grouping of the collection; it has character, pose"),
        (["task.truth=character"], "task.truth=character: expected labels that each group has once, and both have"),
    ],
)
def test_mistakes(run, overrides, message):
    with pytest.raises(InputError, match=message):
        run(*overrides)
