"""A sweep becomes one table: mean ± deviation over seeds, grouped by what else was swept."""

import csv
import itertools

import numpy as np
import pytest

from lssd_learn.sweeps.runs import read_runs
from lssd_learn.sweeps.summary import to_figure, to_markdown, write_csv
from lssd_learn.sweeps.table import summarise
from lssd_learn.tasks.summary import run

COMMON = ["debug=fast"]


@pytest.fixture
def table(leave_run, tmp_path):
    """Two nets, three sizes, three seeds; a size fails for one net, and one run of another."""
    for job, (net, keep, seed) in enumerate(itertools.product(("cnn", "mlp"), (5, 10, 40), range(3))):
        overrides = [*COMMON, f"net={net}", f"latent.keep={keep}", f"seed={seed}"]
        metrics = {"train/mse": 0.5, "test/mse@2": 3.0, "test/mse": keep + seed + 100 * (net == "mlp"), "best_epoch": 7}
        if (net, keep) == ("mlp", 40) or (net, keep, seed) == ("cnn", 5, 2):
            leave_run(str(job), overrides, None, error="too large")
        else:
            leave_run(str(job), overrides, metrics)
    return summarise(read_runs(tmp_path))


def test_groups_are_everything_but_the_seed(table):
    assert table.keys == ["net", "latent.keep"]
    assert [tuple(group.values.values()) for group in table.groups] == [
        ("cnn", "5"), ("cnn", "10"), ("cnn", "40"), ("mlp", "5"), ("mlp", "10"), ("mlp", "40"),
    ]  # fmt: skip
    assert [(len(group.runs), group.failed) for group in table.groups] == [(2, 1), *[(3, 0)] * 4, (0, 3)]
    assert table.groups[1].scores["test/mse"] == (11, 1)  # of 10, 11, 12
    assert table.groups[0].scores["test/mse"] == pytest.approx((5.5, np.sqrt(0.5)))
    assert table.groups[5].scores == {}
    assert len(table.failed) == 4


def test_test_scores_come_first_and_milestones_after_them(table):
    assert table.metrics == ["test/mse", "test/mse@2", "train/mse", "best_epoch"]
    assert table.chosen == ["test/mse", "test/mse@2"]


def test_the_csv_holds_every_metric(table, tmp_path):
    write_csv(table, tmp_path / "summary.csv")
    with (tmp_path / "summary.csv").open(newline="") as stream:
        rows = list(csv.DictReader(stream))
    assert len(rows) == 6
    assert rows[1] | {"net": "cnn", "latent.keep": "10", "n": "3", "failed": "0", "test/mse": "11.0"} == rows[1]
    assert float(rows[1]["test/mse deviation"]) == 1
    assert rows[5]["n"] == "0"
    assert rows[5]["test/mse"] == rows[5]["test/mse deviation"] == ""


def test_the_markdown_names_what_failed_and_why(table):
    text = to_markdown(table)
    assert "| net | latent.keep | n | failed | test/mse | test/mse@2 |" in text
    assert "| cnn | 10 | 3 | 0 | 11 ± 1 | 3 ± 0 |" in text
    assert "| mlp | 40 | 0 | 3 |  |  |" in text
    assert "4 failed:" in text
    assert "- 2 debug=fast net=cnn latent.keep=5 seed=2: too large" in text


def test_the_figure_is_a_line_for_each_net_over_the_number_swept(table):
    figure = to_figure(table)
    (axes,) = figure.axes
    assert axes.get_xlabel() == "latent.keep"
    assert axes.get_ylabel() == "test/mse"
    lines = {line.get_label(): line.get_xydata().tolist() for line in axes.get_lines()}
    assert lines == {"net=cnn": [[5, 5.5], [10, 11], [40, 41]], "net=mlp": [[5, 106], [10, 111]]}


def test_bars_where_no_number_is_swept(leave_run, tmp_path):
    for net, seed in itertools.product(("cnn", "mlp"), range(2)):
        leave_run(f"{net}{seed}", [f"net={net}", f"seed={seed}"], {"test/mse": seed})
    (axes,) = to_figure(summarise(read_runs(tmp_path))).axes
    assert [label.get_text() for label in axes.get_yticklabels()] == ["net=cnn", "net=mlp"]
    assert [bar.get_width() for bar in axes.patches] == [0.5, 0.5]


def test_one_seed_has_no_deviation(leave_run, tmp_path):
    leave_run("0", ["latent.keep=5"], {"test/mse": 0.123456})
    leave_run("1", ["latent.keep=10"], {"test/mse": float("inf")})
    table = summarise(read_runs(tmp_path))
    assert np.isnan(table.groups[0].scores["test/mse"][1])
    assert "| 5 | 1 | 0.1235 |" in to_markdown(table)
    (axes,) = to_figure(table).axes
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("latent.keep", "test/mse")


def test_a_metric_that_one_run_lacks_has_no_mean(leave_run, tmp_path):
    leave_run("0", ["seed=0"], {"test/mse": 1, "test/l1": 1})
    leave_run("1", ["seed=1"], {"test/mse": 2})
    assert list(summarise(read_runs(tmp_path)).groups[0].scores) == ["test/mse"]


def test_of_runs_asked_for_the_same_the_last_counts(leave_run, tmp_path):
    for number, day in enumerate(("mon", "tue")):
        for seed in range(2):
            leave_run(f"{number}_{day}/{seed}", [f"seed={seed}"], {"test/mse": 10 * number + seed})
    (group,) = summarise(read_runs(tmp_path)).groups
    assert len(group.runs) == 2
    assert group.scores["test/mse"][0] == 10.5


def test_the_task_writes_three_files_and_takes_back_a_figure_of_nothing(leave_run, tmp_path):
    leave_run("0", ["net=cnn"], {"operators": 3.0})
    leave_run("1", ["net=mlp"], None)
    assert run(None, tmp_path, str(tmp_path)) == {"runs": 2, "groups": 2, "failed": 1}
    assert {path.name for path in tmp_path.glob("summary.*")} == {"summary.csv", "summary.md", "summary.png"}
    (tmp_path / "0" / "metrics.json").unlink()
    run(None, tmp_path, str(tmp_path))
    assert {path.name for path in tmp_path.glob("summary.*")} == {"summary.csv", "summary.md"}
