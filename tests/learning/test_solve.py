import functools

import numpy as np
import pytest
import torch
from tensorboard.backend.event_processing.event_accumulator import EventAccumulator

from lssd_learn.errors import InputError
from lssd_learn.learning import Classification, Regression, ShapeData, fit, load, split
from lssd_learn.nets import CNN, KernelMachine

FIVE = functools.partial(KernelMachine, rounds=5)


@pytest.fixture
def train(data, tmp_path):
    def run(net=FIVE, shapes=data, **options):
        return fit(net, shapes, epochs=500, learning_rate=None, seed=0, out=tmp_path, **options)

    return run


def test_it_leaves_what_every_training_leaves(train, data, tmp_path):
    metrics = train(carries={"latent": {"Y": torch.ones(2)}}, milestones=(3,), hyperparameters={"net": "kernel"})
    assert set(metrics) == {
        *(f"{part}/{name}" for part in ("train", "validation", "test") for name in Regression.names),
        "generalisation_error",
        "best_epoch",
        "seconds/fit",
    }
    assert 1 <= metrics["best_epoch"] <= 5
    assert metrics["test/mse"] < 0.1 * data.targets.var()
    assert torch.load(tmp_path / "best.ckpt", weights_only=True)["latent"]["Y"].sum() == 2
    operators, parameters = data.part("test")
    loaded = load(tmp_path / "best.ckpt", KernelMachine)  # whatever its options were
    assert ((loaded(operators) - parameters) ** 2).mean() == pytest.approx(metrics["test/mse"], rel=1e-4)


def test_the_best_round_is_kept(train, tmp_path):
    metrics = train()
    events = EventAccumulator(str(tmp_path / "tensorboard"))
    events.Reload()
    curve = [event.value for event in events.Scalars("validation/relative_mse")]
    assert len(curve) == len(events.Scalars("train/l1")) == 5
    assert metrics["best_epoch"] == int(np.argmin(curve)) + 1
    assert metrics["validation/relative_mse"] == pytest.approx(min(curve), rel=1e-4)


def test_again_it_gives_the_same(train):
    first, second = train(), train()
    assert {**first, "seconds/fit": 0} == {**second, "seconds/fit": 0}


def test_a_net_is_left_with_the_best_round(train, data, tmp_path):
    net = FIVE(1, 10, 3)
    metrics = train(net)
    operators, parameters = data.part("validation")
    told = load(tmp_path / "best.ckpt", KernelMachine).told(net(operators))  # the net itself speaks of one scale
    assert ((told - parameters) ** 2).mean() == pytest.approx(metrics["validation/mse"], rel=1e-4)


def test_labels_are_told_apart(train, collection, tmp_path):
    operators, parameters = collection
    labels = (parameters[:, 0] > 0.33).astype(int) + (parameters[:, 0] > 0.67)
    shapes = ShapeData(operators, labels, split=split(60, 0), seed=0)
    metrics = train(shapes=shapes, module=Classification)
    assert metrics["train/accuracy"] == 1
    assert metrics["test/accuracy"] >= 7 / 9
    assert metrics["train/cross_entropy"] < 0.05
    loaded = load(tmp_path / "best.ckpt", KernelMachine, Classification)
    assert (loaded(shapes.part("train")[0]).argmax(1) == shapes.part("train")[1]).all()


def test_it_goes_on_from_nothing(train, tmp_path):
    with pytest.raises(InputError, match=r"ckpt_path=last.ckpt: this net is solved anew"):
        train(ckpt_path="last.ckpt")


def test_other_nets_want_a_learning_rate(train):
    with pytest.raises(InputError, match="learning_rate=None"):
        train(CNN)
