"""`data.by` as it is configured: no person stands on two sides, whatever the seed, and the checkpoint says who."""

import logging

import numpy as np
import pytest
import torch

from lssd_learn.division.protocols import divide
from lssd_learn.errors import InputError

PEOPLE = ("collection=characters", "collection.characters=5", "collection.topology=notoes_collapse5pc",
          "collection.poses=[rest,sitting,t_pose]", "basis.k=24", "latent.size=20", "latent.keep=12",
          "net=kernel", "net.rounds=2", "parallel.workers=1")  # fmt: skip


@pytest.mark.parametrize("seed", range(4))
def test_a_sweep_over_seeds_parts_nobody(pieces_of, tmp_path, seed):
    pieces = pieces_of(tmp_path, *PEOPLE, "data.by=character", "data.protocol=inductive", f"seed={seed}")
    collection = pieces.pipeline.collection
    parts = divide(collection, pieces.seed, pieces.data)
    sides = [set(np.asarray(collection.groups["character"])[some]) for _, some in parts.items()]
    assert sum(map(len, sides)) == len(set.union(*sides)) == 5
    np.testing.assert_array_equal(pieces.pipeline.fitted, parts.train)


def test_a_kernel_machine_and_its_predictions_know_who_was_seen(runs_of, tmp_path, caplog):
    run = runs_of(*PEOPLE)
    with caplog.at_level(logging.WARNING):
        run("task=regression", "data.by=character")
    assert not any("looks like a block" in line for line in caplog.messages)
    kept = torch.load(tmp_path / "best.ckpt", weights_only=True)
    assert kept["by"] == "character"
    assert len(kept["seen"]) == 4
    caplog.clear()
    run("task=predict", f"ckpt_path={tmp_path / 'best.ckpt'}")
    assert any(line.startswith("12 of 15 shapes are of a character that the net was trained on") for line in
               caplog.messages)  # fmt: skip


def test_without_it_a_regression_warns(runs_of, caplog):
    with caplog.at_level(logging.WARNING):
        runs_of(*PEOPLE, "collection.characters=8")("task=regression")
    (line,) = (line for line in caplog.messages if "looks like a block" in line)
    assert line.startswith("character looks like a block")
    assert line.endswith("errors on shapes like those of training flatter a net; data.by=character")


def test_a_kernel_machine_rehearses_poses_and_other_nets_refuse(runs_of, pieces_of, tmp_path):
    run = runs_of(*PEOPLE)
    plain = run("task=regression")
    rehearsed = run("task=regression", "data.rehearse=pose")
    assert plain["test/mse"] != rehearsed["test/mse"]
    run = runs_of(*(one for one in PEOPLE if not one.startswith("net")))
    for net, twins, name in (("cnn", "none", "pose"), ("kernel", "mesh", "pose"), ("kernel", "none", "man")):
        with pytest.raises(InputError, match=f"^data.rehearse={name}: expected"):
            run("task=regression", f"net={net}", f"data.twins={twins}", f"data.rehearse={name}")
