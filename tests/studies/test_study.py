import csv
import logging

import numpy as np
import pytest
from torch.utils.tensorboard import SummaryWriter

from lssd_learn.errors import InputError
from lssd_learn.studies.study import run

SEEDS = (0, 1)


@pytest.fixture
def study(leave_run, tmp_path):
    """A function that leaves two seeds of a run, in a sweep of this name, and curves of the first."""

    def make(sweep, mse, *overrides, **more):
        for seed in SEEDS:
            scores = {"test/mse": mse + 0.001 * seed, "test/l1": 5 * mse, **more}
            scores |= {"test/mse@500": mse + 0.01 * seed, "generalisation_error@500": mse / 2}
            name = f"{sweep}/{'-'.join(overrides) or sweep}-{seed}"
            folder = leave_run(name, [*overrides, f"seed={seed}"], scores)
            with SummaryWriter(str(folder / "tensorboard")) as writer:
                for epoch in range(1, 31):
                    writer.add_scalar("train/mse", mse / epoch, epoch)
                    writer.add_scalar("validation/mse", 2 * mse / epoch, epoch)

    return make


@pytest.fixture
def finished(study, leave_run):
    ridge = {"reference/ridge/mse": 0.004, "reference/ridge/l1": 0.04}
    for net, factor in (("cnn", 1), ("mlp", 2)):
        for network in ("clique", "nearest_20"):
            for keep in (20, 40):
                asked = (f"network={network}", f"latent.keep={keep}", f"net={net}")
                study("operators", factor * 0.4 / keep, *asked, **ridge)
    study("wide", 0.006, "network=clique", "net=cnn")
    study("pointnet", 0.05, "net=pointnet", "net.variant=B", "net.learning_rate=0.005")
    study("baselines", 0.0, "task=baselines", **{"reference/mean/mse": 0.08, "reference/mean/l1": 0.25})
    for rate, error in ((0.001, 0.07), (0.005, 0.04)):
        asked = ["net=pointnet", "net.variant=B", f"net.learning_rate={rate}"]
        leave_run(f"pool/{rate}", asked, {"validation/mse": error})


def rows(path):
    with path.open(encoding="utf-8") as stream:
        return {line["row"]: line for line in csv.DictReader(stream)}


def test_the_table_is_that_of_the_paper_with_ours_below(finished, tmp_path):
    out = tmp_path / "out"
    out.mkdir()
    metrics = run(None, out, str(tmp_path))
    table = rows(out / "table.csv")
    cnn = table["CNN, clique, 40"]
    assert float(cnn["MSE@500"]) == pytest.approx(0.015) == metrics["CNN, clique, 40/MSE@500"]
    assert float(cnn["MSE@500 deviation"]) == pytest.approx(np.std([0.01, 0.02], ddof=1))
    assert (cnn["n"], cnn["MSE@500 paper"], cnn["MSE@1K paper"]) == ("2", "0.009", "0.005")
    assert float(table["CNN, clique, 40, k = 80"]["MSE@1K"]) == pytest.approx(0.0065)
    assert float(table["ridge, nearest_20, 40"]["L1@1K"]) == pytest.approx(0.04)
    assert float(table["mean of the training split"]["MSE@1K"]) == pytest.approx(0.08)
    assert table["mean of the training split"]["MSE@500"] == ""
    assert table["MLP, nearest_20, 20"]["MSE@500 paper"] == ""
    text = (out / "table.md").read_text(encoding="utf-8")
    assert "| CNN, clique, 40 | 2 | .0150 ± .0071 (.009) |" in text
    assert "Best of the pool by validation: net.variant=B net.learning_rate=0.005, validation MSE 0.0400" in text
    assert all((out / name).read_bytes()[:4] == b"\x89PNG" for name in ("mse.png", "trends.png"))


def test_what_is_not_there_is_left_out_and_said(study, leave_run, tmp_path, caplog):
    study("operators", 0.01, "network=clique", "latent.keep=40", "net=cnn")
    leave_run("operators/9", ["network=clique", "latent.keep=50", "net=cnn"], None, error="out of memory")
    out = tmp_path / "out"
    out.mkdir()
    with caplog.at_level(logging.INFO):
        run(None, out, str(tmp_path))
    assert list(rows(out / "table.csv")) == ["CNN, clique, 40"]
    assert "no finished runs of pointnet" in caplog.text
    assert "left out: operators/9 network=clique latent.keep=50 net=cnn: out of memory" in caplog.text
    assert (out / "mse.png").exists()
    assert not (out / "trends.png").exists()


def test_a_folder_of_something_else_is_refused(study, tmp_path):
    study("tries", 0.01, "net=cnn")
    with pytest.raises(InputError, match="expected the sweeps operators, wide, .* found none"):
        run(None, tmp_path, str(tmp_path))
