"""A finished job of a sweep is kept; a failed, missing or other one is not."""

import json
import logging

import pytest

from lssd_learn.command.finished import finished

JOB = ["net=mlp", "seed=1"]


@pytest.fixture
def done(tmp_path):
    (tmp_path / "metrics.json").write_text('{"validation/mse": 0.5}')
    (tmp_path / "provenance.json").write_text(json.dumps({"command": "python train.py net=mlp seed=1"}))
    return tmp_path


@pytest.mark.parametrize("overrides", [JOB, JOB[::-1], [*JOB, "ckpt_path=last"]])
def test_the_same_job_is_kept(done, overrides, caplog):
    with caplog.at_level(logging.INFO):
        assert finished(done, overrides) == {"validation/mse": 0.5}
    assert "was finished before and is kept" in caplog.text


def test_whatever_the_program_was_called(done):
    (done / "provenance.json").write_text(json.dumps({"command": "lssd net=mlp seed=1"}))
    assert finished(done, JOB) == {"validation/mse": 0.5}


def test_another_job_is_made_anew_and_said(done, caplog):
    assert finished(done, ["net=cnn", "seed=1"]) is None
    assert "holds a run of net=mlp seed=1; it is made anew, of net=cnn seed=1" in caplog.text


@pytest.mark.parametrize("name", ["metrics.json", "provenance.json"])
def test_a_failed_or_killed_job_is_not_finished(done, name):
    (done / name).unlink()
    assert finished(done, JOB) is None
