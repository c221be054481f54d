"""The line after Ctrl-C is a command that goes on."""

import sys
import time

import pytest

from lssd_learn.command.interrupted import how_to_go_on


@pytest.fixture(autouse=True)
def _program(monkeypatch):
    monkeypatch.setattr(sys, "argv", ["train.py"])


def test_training_goes_on_from_its_last_checkpoint(tmp_path):
    (tmp_path / "last.ckpt").touch()
    line = how_to_go_on(["net=mlp", "hydra.run.dir=x"], time.time() - 60, [tmp_path], False)
    assert line.endswith(f": python train.py net=mlp hydra.run.dir={tmp_path} ckpt_path=last")


def test_before_training_the_same_command_is_given(tmp_path):
    (tmp_path / "last.ckpt").touch()  # of an earlier run
    line = how_to_go_on(["net=mlp"], time.time() + 60, [tmp_path], False)
    assert line.endswith(": python train.py net=mlp")


def test_a_sweep_goes_on_in_its_folder(tmp_path):
    line = how_to_go_on(["-m", "seed=0,1"], time.time(), [tmp_path], True)
    assert line.endswith(f": python train.py -m seed=0,1 hydra.sweep.dir={tmp_path}")
