"""`task=benchmark` measures every stage. How long anything takes is nobody's business here."""

import csv
import importlib
import os
import pickle
import sys
import time
from functools import partial
from importlib.util import find_spec

import numpy as np
import pytest

from lssd_learn.errors import InputError
from lssd_learn.measures.speed import benchmark
from lssd_learn.measures.speed.stopwatch import Measured, WorkFailedError, _timed, measure
from lssd_learn.measures.speed.timetable import STAGES, Row, growths, megabytes_at, render

TINY = (
    "task=benchmark", "collection=bodies_small", "collection.n=8", "basis.k=20", "latent.size=10", "latent.keep=10",
    "task.functions=[20]", "task.shapes=[4,8]", "task.peer_most=4", "task.epochs=1", "task.repeats=1", "task.threads=1",
    "task.foretell=500",
)  # fmt: skip


@pytest.fixture
def train(runs_of):
    """A function (overrides) → the metrics of a tiny benchmark; its files lie in `tmp_path`."""
    return runs_of(*TINY)


@pytest.fixture
def here(monkeypatch):
    """All work is done in this process: one of its own for each of ten, and they would do little but import."""

    def measured(work, threads=1, processor=False):
        with pytest.MonkeyPatch.context() as environment:
            environment.setenv("LSSD_CACHE", os.environ["LSSD_CACHE"])  # which it may set as it likes
            got = _timed(pickle.loads(pickle.dumps(work)), processor)  # it travels all the same
        return Measured(got["laps"], got["memory"] / 1e6, got["result"])

    monkeypatch.setattr(benchmark, "measure", measured)


@pytest.mark.parametrize("where", ["here", pytest.param("there", marks=pytest.mark.slow)])
def test_every_stage_is_measured_and_shown(train, tmp_path, caplog, where, request):
    if where == "here":
        request.getfixturevalue("here")
    with caplog.at_level("INFO"):
        metrics = train()
    stages = [
        "eigenbasis/k20",
        "latent/n4",
        "operators/n4",
        "network/n4",
        "network/n8",
        "latent/n8",
        "operators/n8",
        "scaling/n4",
        "scaling/n8",
    ]
    stages += ["cache", "training", "eigenbases/n4", "eigenbases/n8"]
    with (tmp_path / "benchmark.csv").open() as stream:
        rows = {row["stage"]: row for row in csv.DictReader(stream)}
    assert set(rows) == set(stages)
    for stage in stages:
        assert metrics[f"{stage}/seconds"] > 0
        assert float(rows[stage]["seconds"]) == metrics[f"{stage}/seconds"]
        assert stage in caplog.text
    for stage in ("eigenbasis/k20", "latent/n8", "scaling/n8", "training"):
        assert metrics[f"{stage}/megabytes"] > 10
    assert [bool(rows[f"latent/n{n}"]["exponent"]) for n in (4, 8)] == [False, True]
    assert np.isfinite([metrics[f"{stage}/exponent"] for stage in STAGES]).all()
    assert caplog.text.count("of 500 shapes") == len(
        STAGES
    )  # the memory among them; on one thread `scaling` is `latent`
    assert "memory of 500 shapes" in caplog.text
    assert metrics["training/ratio"] > 0
    assert metrics["training/difference"] == 0  # the bare loop is the same training
    assert (tmp_path / "benchmark.png").stat().st_size > 5000

    compared = {name for name in metrics if name.endswith("peer_seconds")} - {
        "cache/peer_seconds",
        "training/peer_seconds",
    }
    if find_spec("pyFM"):
        assert compared == {f"{stage}/peer_seconds" for stage in ("eigenbasis/k20", "latent/n4", "operators/n4")}
        assert metrics["latent/n4/difference"] < 1e-3
        assert metrics["latent/n4/ratio"] == metrics["latent/n4/peer_seconds"] / metrics["latent/n4/seconds"]
        assert metrics["latent/n4/peer_megabytes"] > 10
    else:
        assert not compared
        assert "pip install pyfmaps" in caplog.text


@pytest.mark.parametrize(
    ("override", "message"),
    [
        ("task.shapes=[4,9]", r"shapes=\[4, 9\]: expected numbers from 2 to 8, the shapes of the collection"),
        ("task.functions=[]", r"functions=\[\]: expected numbers of eigenfunctions"),
        ("task.repeats=0", "repeats=0: expected 1 or more"),
    ],
)
def test_a_mistake_is_told_before_any_work(train, override, message, tmp_path):
    with pytest.raises(InputError, match=message):
        train(override)
    assert not (tmp_path / "cache").exists()


WORK = """
import numpy as np

def work(fail=None):
    memory = np.ones(1)
    yield "large"
    memory = np.ones(25_000_000)  # 200 MB
    yield "small"
    if fail is not None:
        raise fail
    yield None
    return len(memory)
"""


@pytest.fixture
def work(tmp_path, monkeypatch):
    """A piece of work in a module that another process can import too."""
    (tmp_path / "some_work.py").write_text(WORK)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "some_work", raising=False)
    return importlib.import_module("some_work").work


def test_the_stopwatch_tells_laps_memory_and_result(work):
    measured = measure(work)
    assert list(measured.laps) == ["large", "small"]
    assert min(measured.laps.values()) > 0
    assert measured.seconds == sum(measured.laps.values())
    assert 200 < measured.megabytes < 400
    assert measured.result == 25_000_000


def sleeping():
    yield "nap"
    time.sleep(0.2)
    yield None


def test_the_processor_does_not_count_what_only_passes():
    assert _timed(sleeping, processor=False)["laps"]["nap"] > 0.19
    assert _timed(sleeping, processor=True)["laps"]["nap"] < 0.1


def test_errors_of_the_work_come_back(work):
    with pytest.raises(InputError, match="too many"):
        measure(partial(work, InputError("too many")))
    with pytest.raises(WorkFailedError, match="ValueError: why"):
        measure(partial(work, ValueError("why")))


def test_growth_is_the_slope_of_a_power():
    rows = [Row(f"latent/n{n}", 1, 3 * n**1.5, peer_seconds=n**2.0 if n < 100 else None) for n in (10, 50, 200)]
    found = growths([*rows, Row("scaling/n10", 4, 1.0), Row("cache", 4, 1.0)])
    assert found["latent/exponent"].exponent == pytest.approx(1.5)
    assert found["latent/peer_exponent"].exponent == pytest.approx(2)
    assert found["latent/peer_exponent"].sizes == [10, 50]
    assert found["scaling/exponent"].exponent is None
    assert found["latent/exponent"].at(10_000) == pytest.approx(3e6)


def test_memory_grows_along_a_line():
    rows = [Row(f"scaling/n{n}", 2, 1.0, 200 + 3.0 * n) for n in (10, 50, 200)]
    assert megabytes_at([*rows, Row("latent/n10", 1, 1.0, 5.0)], 1000) == pytest.approx(3200)


def test_the_ratio_is_how_many_times_faster_or_what_a_bare_loop_would_save():
    assert Row("latent/n9", 1, 2.0, against="pyfmaps", peer_seconds=20.0).ratio == 10
    assert Row("training", 1, 3.0, against="bare loop", peer_seconds=2.0).ratio == 1.5
    assert Row("scaling/n9", 1, 2.0).ratio is None
    assert "pyfmaps" in render([Row("latent/n9", 1, 2.0, against="pyfmaps", peer_seconds=20.0)], "title")
