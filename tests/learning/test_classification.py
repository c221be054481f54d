import functools
import math

import numpy as np
import pytest
import torch

from lssd_learn.learning import Classification, ShapeData, fit, load, split
from lssd_learn.learning.checkpoint import read
from lssd_learn.nets import CNN, MLP

TINY = functools.partial(MLP, first=16, hidden=(16,))


@pytest.fixture(scope="module")
def shapes(collection):
    """The operators, and which third of the first parameter each is in."""
    operators, parameters = collection
    return ShapeData(operators, np.digitize(parameters[:, 0], [1 / 3, 2 / 3]), split=split(60, 0), seed=0, batch=16)


def test_scores_of_logits_by_hand():
    logits = torch.tensor([[0.0, 0.0], [math.log(3), 0.0], [0.0, math.log(3)]])
    entropy, accuracy = Classification(torch.nn.Identity(), 0.1).scores(logits, torch.tensor([0, 0, 0]))
    assert entropy == pytest.approx(-(math.log(1 / 2) + math.log(3 / 4) + math.log(1 / 4)) / 3)
    assert accuracy == pytest.approx(2 / 3)  # of two equal ones the first


@pytest.mark.parametrize("net", [CNN, TINY])
def test_it_learns_and_is_chosen_by_the_cross_entropy(shapes, tmp_path, net):
    carries = {"group": "third", "classes": ["low", "middle", "high"]}
    metrics = fit(
        net, shapes, epochs=100, learning_rate=0.01, seed=0, out=tmp_path, module=Classification, carries=carries
    )
    assert metrics["train/accuracy"] > 0.95
    assert metrics["test/accuracy"] > 0.8
    assert metrics["generalisation_error"] == metrics["test/cross_entropy"] - metrics["train/cross_entropy"]
    checkpoint = read(tmp_path / "best.ckpt")
    assert carries.items() <= checkpoint.items()
    assert checkpoint["value"] == pytest.approx(metrics["validation/cross_entropy"], rel=1e-4)
    inputs, labels = shapes.part("test")
    with torch.no_grad():
        answers = load(tmp_path / "best.ckpt", net, Classification)(inputs).argmax(1)
    assert (answers == labels).float().mean() == pytest.approx(metrics["test/accuracy"])


def test_a_resumed_run_goes_on_in_the_warm_up(shapes, tmp_path):
    def train(out, epochs, **options):
        options = {"learning_rate": 0.05, "seed": 0, "out": tmp_path / out, "module": Classification} | options
        metrics = fit(TINY, shapes, epochs=epochs, **options)
        return {name: value for name, value in metrics.items() if name != "seconds/fit"}

    whole = train("whole", 30)  # of three steps each
    train("cut", 10)
    assert train("cut", 30, ckpt_path=tmp_path / "cut" / "last.ckpt") == whole
