"""Columns that nobody named: blocks and sides are told, and what is no such thing is not."""

import logging

import numpy as np
import pytest
import torch

from lssd_learn.collections import ShapeList
from lssd_learn.learning import ShapeData, split
from lssd_learn.nets import KernelMachine
from lssd_learn.pushing import warn_of_frames
from lssd_learn.unsaid import warn_of_beyond, warn_of_blocks, warn_of_ridge, warn_of_seen, warn_of_sides


@pytest.fixture
def people():
    """Twelve people of three scans each: a collection with columns of labels, and operators (36, 2, 4, 4)."""
    rng, who = np.random.default_rng(0), np.repeat(np.arange(12), 3)
    D = rng.normal(size=(12, 2, 4, 4))[who] + 0.1 * rng.normal(size=(36, 2, 4, 4))
    collection = ShapeList([None] * 36)
    collection.groups = {
        "person": np.array([f"p{i}" for i in who]),
        "site": np.tile(["a", "b", "c"], 12),
        "session": np.array([f"s{i % 9}" for i in range(36)]),
        "sex": np.array(["f", "m"])[who % 2],
    }
    return collection, torch.from_numpy(D)


def warnings(caplog):
    return [record.getMessage() for record in caplog.records if record.levelno == logging.WARNING]


def test_a_column_of_people_looks_like_blocks(people, caplog):
    warn_of_blocks(*people, "task.blocks", "p-values take all shapes as independent", besides=["sex"])
    (line,) = warnings(caplog)
    assert line.startswith("person looks like a block of shapes that belong together: 100 % of the shapes have")
    assert line.endswith("(6 % by chance), and p-values take all shapes as independent; task.blocks=person")


def test_one_that_is_asked_for_or_means_nothing_is_not_told(people, caplog):
    collection, D = people
    warn_of_blocks(collection, D, "task.blocks", "", besides=["person"])
    warn_of_blocks(collection, torch.from_numpy(np.random.default_rng(1).normal(size=D.shape)), "task.blocks", "")
    assert not warnings(caplog)


def test_numbers_may_be_people_too(people, caplog):
    collection, D = people
    numbers = np.stack([np.repeat(np.arange(12), 3), np.random.default_rng(0).normal(size=36)], 1)
    collection.groups, collection.parameters, collection.parameter_names = {}, numbers, ["person", "age"]
    warn_of_blocks(collection, D, "data.by", "errors flatter")
    assert warnings(caplog)[0].endswith("errors flatter; collection.groups=[person] data.by=person")


def test_where_a_target_varies_within_blocks_a_split_may_part_them(people, caplog):
    collection, D = people
    own = np.random.default_rng(0).normal(size=(36, 1))
    warn_of_blocks(collection, D, "data.by", "", targets=own)
    assert not warnings(caplog)
    shared = np.repeat(own[:12], 3, axis=0) + 0.1 * own
    warn_of_blocks(collection, D, "data.by", "", targets=np.hstack([own, shared]))
    warn_of_blocks(collection, D, "data.by", "", targets=np.repeat(np.arange(12) % 2, 3))
    assert len(warnings(caplog)) == 2


@pytest.mark.parametrize("names", [("left", "right"), ("L", "r")])
def test_a_side_that_nobody_asked_for_is_told(people, names, caplog):
    collection, D = people
    side = np.arange(36) % 2
    collection.groups["side"] = np.array(names)[side]
    warn_of_sides(collection, D, ["area", "conformal"])
    assert not any("side" in line for line in warnings(caplog))
    caplog.clear()
    D[:, 0, 0, 1] += 12 * torch.from_numpy(side)
    warn_of_sides(collection, D, ["area", "conformal"], sides_only=True)
    (line,) = warnings(caplog)
    assert line.startswith("principal component 1 of the area operators is side (correlation ")
    assert line.endswith("which nothing here asks for; collection.align=rigid collection.mirror=allow lays all shapes "
                         "on one side")  # fmt: skip
    caplog.clear()
    warn_of_sides(collection, D, ["area", "conformal"], besides=["side"])
    assert not any("side" in line for line in warnings(caplog))


def test_shapes_beyond_those_of_training_are_told(caplog):
    rng, who = np.random.default_rng(0), np.repeat(np.arange(20), 2)
    X = (rng.normal(size=(20, 1, 3, 3))[who] + 0.1 * rng.normal(size=(40, 1, 3, 3))) / 4
    D = torch.matrix_exp(torch.from_numpy(X + X.swapaxes(2, 3)))
    parts = split(40, 0, blocks=who)
    D[parts.test] = D[parts.train][: len(parts.test)] * 1.01
    targets = D[:, 0, 0, :1].log()
    for far in (1, 30):
        D[parts.test] *= far
        data = ShapeData(D, targets, split=parts, seed=0, standardise_targets=False)
        net = KernelMachine(1, 3, 1, rounds=2, bounded=far > 1)
        list(net.solve(data.part("train"), data.part("validation")))
        warn_of_beyond(net, data.inputs, parts, who, "person")
    (line,) = warnings(caplog)
    assert line.startswith(f"{len(parts.test)} of {len(parts.test)} test shapes are less like the training shapes than")


def test_people_a_net_was_trained_on_are_told(people, caplog):
    collection, _ = people
    warn_of_seen(collection, "person", ["q1", "q2"])
    warn_of_seen(collection, "animal", ["p1"])
    assert not warnings(caplog)
    warn_of_seen(collection, "person", ["p1", "p3"])
    assert warnings(caplog) == [
        "6 of 36 shapes are of a person that the net was trained on (p1, p3): errors on these flatter it"
    ]


def test_outputs_of_a_ridge_and_shapes_that_were_laid_alike_are_told(caplog):
    net = KernelMachine(1, 4, 3)
    warn_of_ridge(net, ["age", "mass", "height"])
    warn_of_frames("none")
    assert not caplog.messages
    net.linear = torch.tensor([True, False, True])
    warn_of_ridge(net, ["age", "mass", "height"])
    warn_of_ridge(net, [])
    warn_of_frames("rigid")
    assert [message.partition(":")[0] for message in caplog.messages[:2]] == ["age, height", "output 0, output 2"]
    assert "the training shapes were laid alike (collection.align=rigid)" in caplog.messages[2]
