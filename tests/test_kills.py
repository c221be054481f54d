"""SIGKILL at random moments, then the same work again: it ends with the bits of an undisturbed run.

`pytest -n 0 -m slow tests/test_kills.py -s` says how many kills were survived.
"""

import json
import os
import signal
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
import pytest
import torch

from lssd_learn.cache import Cache
from lssd_learn.collections import Bodies
from lssd_learn.learning import ShapeData, fit, split
from lssd_learn.nets import CNN, KernelMachine
from lssd_learn.pipeline import Pipeline

pytestmark = [pytest.mark.slow, pytest.mark.skipif(not hasattr(os, "fork"), reason="forks")]

KILLS = 20  # at least
IN_A_ROW = 4  # the work is killed so many times, if it does not finish before, and then left to finish


def killed_again_and_again(work: Callable[[Path], None], folder: Path, seed: int) -> tuple[list[Path], int]:
    """The folders in which `work` was left to finish after kills, the first without any, and how many kills there were.

    The work is done by forks of this process, which has imported all it needs: kills fall into the work itself.
    """
    rng, kills, folders = np.random.default_rng(seed), 0, []
    undisturbed, _ = _run(work, folder / "undisturbed", None)
    folders.append(folder / "undisturbed")
    while kills < KILLS:
        here = folder / str(len(folders))
        for _ in range(IN_A_ROW):
            kills += _run(work, here, rng.uniform(0, undisturbed))[1]
        assert not _run(work, here, None)[1]
        folders.append(here)
    return folders, kills


def _run(work: Callable[[Path], None], folder: Path, seconds: float | None) -> tuple[float, bool]:
    """How long it took, and whether it was killed."""
    folder.mkdir(exist_ok=True)
    start, child = time.monotonic(), os.fork()
    if child == 0:
        status = 1
        try:
            work(folder)
            status = 0
        finally:
            os._exit(status)
    done, status = 0, 0
    while seconds is not None and not done and time.monotonic() - start < seconds:
        time.sleep(0.001)
        done, status = os.waitpid(child, os.WNOHANG)
    if not done:
        if seconds is not None:
            os.kill(child, signal.SIGKILL)
        _, status = os.waitpid(child, 0)
    killed = os.WIFSIGNALED(status) and os.WTERMSIG(status) == signal.SIGKILL
    assert killed or os.waitstatus_to_exitcode(status) == 0
    return time.monotonic() - start, killed


@pytest.fixture(scope="module")
def bodies():
    collection = Bodies(48, topology="notoes_collapse5pc")
    _ = collection[0]  # the model is in memory, and in every fork
    return collection


def preprocess(bodies) -> Callable[[Path], None]:
    def work(folder: Path) -> None:
        sizes = {"k": 24, "size": 20, "keep": 12, "workers": 1, "cache": Cache(folder / "cache")}
        pipeline = Pipeline(bodies, **sizes)
        arrays = pipeline.operators(("area", "conformal")).numpy(), pipeline.clouds(256)
        np.savez(folder / "result.npz", *arrays)

    return work


def test_preprocessing(bodies, tmp_path):
    folders, kills = killed_again_and_again(preprocess(bodies), tmp_path, seed=0)
    results = [dict(np.load(folder / "result.npz")) for folder in folders]
    for result in results[1:]:
        for name, array in results[0].items():
            np.testing.assert_array_equal(result[name], array)
    for folder in folders:  # what a kill left half-written was taken away, or would be
        assert len(list((folder / "cache" / "eigenbasis").glob("*/*.arrays"))) == len(bodies)
    print(f"preprocessing: {kills} kills, {len(folders) - 1} results equal to the undisturbed")


def compare(what: str, folders: list[Path], kills: int) -> None:
    """The metrics of each folder with those of the first, of the undisturbed run."""
    results = [json.loads((folder / "metrics.json").read_text()) for folder in folders]
    for result in results:
        result.pop("seconds/fit")
        assert result == results[0]
    print(f"{what}: {kills} kills, {len(folders) - 1} results equal to the undisturbed")


def test_many_shapes(bodies, tmp_path, monkeypatch):
    """What is done otherwise for many shapes: factors on the disk, a reader of which some shapes are the centres."""
    monkeypatch.setattr("lssd_learn.latent.factors.HELD", 0)
    monkeypatch.setattr("lssd_learn.latent.network.EXACT_PRODUCTS", 0)
    monkeypatch.setattr("lssd_learn.latent.differences.TOGETHER", 7)
    reader = partial(KernelMachine, exact=20, centres=20, rounds=2)

    def work(folder: Path) -> None:
        sizes = {"k": 24, "size": 20, "keep": 12, "workers": 1, "cache": Cache(folder / "cache")}
        operators = Pipeline(bodies, **sizes).operators(("area", "conformal"))
        data = ShapeData(operators, bodies.parameters, split=split(len(bodies), 0), seed=0)
        metrics = fit(reader, data, epochs=1, learning_rate=None, seed=0, out=folder)
        (folder / "metrics.json").write_text(json.dumps(metrics))

    folders, kills = killed_again_and_again(work, tmp_path, seed=2)
    compare("many shapes", folders, kills)


def test_training(bodies, tmp_path):
    operators = Pipeline(bodies, k=24, size=20, keep=12, workers=1, cache=Cache(tmp_path / "cache")).operators()

    def work(folder: Path) -> None:
        torch.set_num_threads(1)
        data = ShapeData(operators, bodies.parameters, split=split(len(bodies), 0), seed=0, batch=10)
        last = folder / "last.ckpt"
        metrics = fit(
            CNN, data, epochs=150, learning_rate=0.005, seed=0, out=folder, checkpoint_every=5,
            ckpt_path=last if last.exists() else None,
        )  # fmt: skip
        (folder / "metrics.json").write_text(json.dumps(metrics))

    folders, kills = killed_again_and_again(work, tmp_path, seed=1)
    compare("training", folders, kills)
