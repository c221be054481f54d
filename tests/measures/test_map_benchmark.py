"""`task=map_benchmark`: the table of generated bodies, its sums, and what it is asked for."""

import csv

import numpy as np
import pytest

from lssd_learn.collections import Bodies, Remeshed
from lssd_learn.errors import InputError
from lssd_learn.measures.map_benchmark import choose, summary
from lssd_learn.measures.map_scores import pairs_by

BODIES = (
    "task=map_benchmark", "collection=remeshed", "collection.base.topology=notoes_collapse10pc",
    "collection.base.n=4", "collection.base.scans=2", "collection.base.poses=random", "collection.vertices=[650,700]",
    "collection.turned=any", "basis.k=40", "latent.size=12", "latent.keep=10",
)  # fmt: skip


def rows(path):
    with path.open(newline="") as stream:
        return list(csv.DictReader(stream))


def test_a_table_of_bodies(runs_of, tmp_path):
    metrics = runs_of(*BODIES, "maps=auto")("task.by=person", "task.pairs=1", "task.points=60")
    table, pairs = rows(tmp_path / "map_benchmark.csv"), rows(tmp_path / "pairs.csv")
    assert [row["kind"] for row in table] == ["same_person", "other_person"]
    for row, pair in zip(table, sorted(pairs, key=lambda pair: pair["kind"], reverse=True), strict=True):
        assert row["pairs"] == "1"
        assert row["error"] == row["worst"] == pair["error"]
        assert metrics[f"{row['kind']}/error"] == pytest.approx(float(row["error"]), rel=1e-4)
        for name in ("flipped", "turned", "quality", "seconds"):
            assert row[name] == pair[name]
        assert float(row["error"]) < 0.05  # a random map: about .5
        assert 1 - float(row["auc"]) < float(row["error"]) / 0.25 + 1e-6  # errors beyond the curve count less there
        assert float(row["flipped"]) < 0.02
    assert [float(pair["error"]) for pair in pairs] == sorted((float(pair["error"]) for pair in pairs), reverse=True)
    assert (tmp_path / "curve.png").stat().st_size > 5000


def test_sums():
    made = [{"kind": "all", "error": e, "turned": 0.1, "quality": q} for e, q in ((0.01, 0.9), (0.09, 0.8), (0.2, 0.1))]
    told = summary(made, np.array([0.0, 0.125, 0.5]), 0.25, 0.5)
    assert told["error"] == pytest.approx(0.1)
    assert told["worst"] == 0.2
    assert told["auc"] == pytest.approx(0.5)
    assert (told["trusted"], told["trusted_bad"], told["untrusted_bad"]) == (2, 0.5, 1.0)
    assert "flipped" not in told


@pytest.fixture(scope="module")
def collection():
    bodies = Bodies(n=6, scans=2, poses="random", topology="notoes_collapse3pc")
    return Remeshed(bodies, vertices=(300, 320))


def test_pairs_of_a_group(collection):
    found = pairs_by(collection, "person", 50, np.random.default_rng(0))
    assert len(found) == 15  # each once
    for kind, i, j in found:
        assert kind == ("same_person" if i // 2 == j // 2 else "other_person")
    assert len(pairs_by(collection, "person", 2, np.random.default_rng(0))) == 4


def test_pairs_that_are_listed(collection, tmp_path):
    file = tmp_path / "pairs.txt"
    file.write_text("body_0001 body_0004\nbody_0003,body_0000\n\n")
    assert choose(collection, str(file), None, 0) == [("all", 1, 4), ("all", 3, 0)]
    file.write_text("body_0001\nbody_0004.off\n")
    assert choose(collection, str(file), None, 0) == [("all", 1, 4), ("all", 4, 1)]
    assert len(choose(collection, None, None, 0)) == 30
    some = choose(collection, 4, None, 0)
    assert len(set(some)) == 4
    assert some == choose(collection, 4, None, 0) != choose(collection, 4, None, 1)
    for text, message in (
        ("body_0001 nobody", "expected one or two names of shapes a line, such as body_0000, got body_0001 nobody"),
        ("body_0001\nbody_0001 body_0002", "expected a name a line, or two on each line"),
        ("body_0001 body_0001", "expected pairs whose true map is known, got body_0001 and body_0001"),
        ("", "expected a name a line, or two"),
    ):
        file.write_text(text)
        with pytest.raises(InputError, match=message):
            choose(collection, str(file), None, 0)
    with pytest.raises(InputError, match="task.by=pose: expected one of person"):
        choose(collection, 4, "pose", 0)
    with pytest.raises(InputError, match="nowhere.txt: cannot be read"):
        choose(collection, str(tmp_path / "nowhere.txt"), None, 0)


@pytest.mark.parametrize(
    ("overrides", "message"),
    [
        (["collection=bodies_small", "collection.n=2"], "expected a collection whose true maps are known"),
        (["maps=correspondence"], "expected maps that are computed, such as maps=auto"),
        (["task.points=0"], "task.points=0: expected a whole number, 1 or more"),
        (["task.threshold=0"], "task.threshold=0: expected a number above 0"),
        (["task.pairs=0"], "task.pairs=0: expected a whole number, 1 or more"),
    ],
)
def test_bad_choices_are_refused_before_any_work(runs_of, overrides, message):
    start = [a for a in BODIES if not a.startswith("collection")] if "bodies_small" in overrides[0] else BODIES
    with pytest.raises(InputError, match=message):
        runs_of(*start)("maps=auto" if "maps" not in overrides[0] else overrides[0], *overrides)
