"""Folders of runs are read as they were left."""

import json

import pytest

from lssd_learn.errors import InputError
from lssd_learn.sweeps.runs import UNFINISHED, differing, read_runs


def test_runs_come_in_natural_order_with_what_they_were_asked_for(leave_run, tmp_path):
    for job in (10, 2, 1):
        leave_run(f"{job}", [f"seed={job}", "+net.layers=[[10,3,2]]"], {"test/mse": job})
    runs = read_runs(tmp_path)
    assert [run.name for run in runs] == ["1", "2", "10"]
    assert runs[2].overrides == {"seed": "10", "net.layers": "[[10,3,2]]"}
    assert runs[2].metrics == {"test/mse": 10}
    assert runs[2].error is None
    assert runs[2].title == "10 seed=10 net.layers=[[10,3,2]]"


def test_runs_may_lie_deeper_and_summaries_are_none(leave_run, tmp_path):
    leave_run("a/x=1,y=2/0", ["seed=0"], {"test/mse": 1})
    leave_run("b/0", ["task=summary", "task.folder=a"], {"runs": 1})
    assert [run.name for run in read_runs(tmp_path)] == ["a/x=1,y=2/0"]


def test_what_failed_says_why(leave_run, tmp_path):
    leave_run("0", ["seed=0"], {"test/mse": 1}, error="no epoch was finite\n")  # the metrics of an earlier run
    leave_run("1", ["seed=1"], None)
    (leave_run("2", ["seed=2"], None) / "metrics.json").write_text('{"test/mse": 0.')
    (leave_run("3", ["seed=3"], None) / "metrics.json").write_text(json.dumps({"test/mse": [1]}))
    errors = [run.error for run in read_runs(tmp_path)]
    assert errors[:2] == ["no epoch was finite", UNFINISHED]
    assert all("damaged" in error for error in errors[2:])


def test_going_on_with_a_run_makes_no_other_of_it(leave_run, tmp_path):
    leave_run("0", ["net=cnn", "seed=0"], {"test/mse": 1})
    leave_run("1", ["net=cnn", "seed=1", "ckpt_path=last"], {"test/mse": 1})
    runs = read_runs(tmp_path)
    assert differing(runs) == []
    assert differing(runs, but=()) == ["seed"]


def test_a_key_that_only_some_runs_name_differs(leave_run, tmp_path):
    leave_run("0", ["debug=fast"], {"test/mse": 1})
    leave_run("1", ["debug=fast", "latent.keep=5"], {"test/mse": 1})
    assert differing(read_runs(tmp_path)) == ["latent.keep"]


def test_a_folder_without_runs_is_refused(leave_run, tmp_path):
    with pytest.raises(InputError, match="holds no runs"):
        read_runs(tmp_path)
    with pytest.raises(InputError, match="there is none"):
        read_runs(tmp_path / "nowhere")
    (leave_run("0", ["seed=0"], None) / ".hydra" / "overrides.yaml").write_text("[seed=0")
    with pytest.raises(InputError, match="expected a list of key=value"):
        read_runs(tmp_path)
