"""`task=power_benchmark` and `task=slope_benchmark` on a few bodies of 615 vertices, through the configuration."""

import csv

import numpy as np
import pytest

from lssd_learn.errors import InputError
from lssd_learn.measures.power_benchmark import dice

SMALL = ("basis.k=30", "latent.size=28", "latent.keep=24", "parallel.workers=1", "collection=grown", "collection.n=16")


@pytest.fixture
def run(runs_of):
    return runs_of(*SMALL)


def test_a_grown_foot_is_found_where_it_is(run, tmp_path):
    few = ("collection.place=foot", "task.people=16", "task.studies=1", "task.permutations=39")
    rates = run("task=power_benchmark", *few)
    assert rates["table"] == rates["anywhere"] == rates["landmarks/table"] == 1
    assert rates["auc"] > 0.95
    assert rates["dice/core"] > 0.6
    assert rates["landmarks/dice"] > 0.6
    assert 0 <= rates["false/core"] <= rates["false"] < 0.5
    with (tmp_path / "power.csv").open() as file:
        (row,) = csv.DictReader(file)
    assert (row["place"], row["people"]) == ("foot", "16")
    paired = run("task=power_benchmark", *few, "task.people=6", "task.paired=true", "task.permutations=64")
    assert paired["p"] == 2 / 64
    assert paired["auc"] > 0.95


def test_bodies_with_meshes_of_their_own(runs_of, tmp_path):
    small = [word.replace("collection", "collection.base") if "." in word else word for word in SMALL[3:]]
    run = runs_of(*SMALL[:3], *(word.replace("=grown", "=remeshed_grown") for word in small))
    few = ("collection.base.place=foot", "task.people=16", "task.studies=1", "task.permutations=39")
    base = ("collection.base.topology=notoes_collapse10pc", "collection.vertices=[900,1200]", "network=hubs")
    rates = run("task=power_benchmark", "maps=correspondence", *few, *base)
    assert rates["table"] == rates["anywhere"] == 1
    assert rates["auc"] > 0.95
    assert rates["landmarks/auc"] > 0.95
    assert (tmp_path / "power.csv").read_text().splitlines()[1].split(",")[3] == "own"


def test_slopes_that_are_known(run):
    rates = run("task=slope_benchmark", "collection.place=foot", "collection.dose=true", "task.people=14",
                "task.studies=5", "collection.topology=notoes_collapse3pc")  # fmt: skip
    assert rates["surface"] > 0.5
    assert abs(rates["bias"]) < 4


@pytest.mark.parametrize(
    ("overrides", "message"),
    [
        (("task=power_benchmark", "collection=bodies_small", "~collection.n"), "expected collection=grown"),
        (("task=slope_benchmark",), "expected collection=grown collection.dose=true"),
        (("task=power_benchmark", "task.people=25"), "task.people=25: expected a whole number, 4 to 16"),
    ],
)
def test_collections_and_numbers_that_do_not_do(run, overrides, message):
    with pytest.raises(InputError, match=message):
        run(*overrides)


def test_overlap_by_area():
    one, other = np.array([True, True, False]), np.array([False, True, True])
    assert dice(one, other, np.array([1.0, 2.0, 3.0])) == pytest.approx(2 * 2 / (3 + 5))
    assert dice(one & ~one, one & ~one, np.ones(3)) == 0
