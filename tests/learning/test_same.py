"""Training goes on only with what it was begun with: these changes, each refused by name, with both values."""

from functools import partial

import numpy as np
import pytest

from lssd_learn.errors import InputError
from lssd_learn.learning import ShapeData, fit, split
from lssd_learn.nets import MLP

N = 20
CHOSEN = {"latent.keep": 6, "net.learning_rate": 0.01, "data.targets": "standardised"}


def shapes(scale=1.0, label=0.0, size=6, seed=0, batch=8, part=0):
    rng = np.random.default_rng(0)
    inputs = np.eye(6) + 0.1 * scale * rng.normal(size=(N, 1, 6, 6))
    targets = rng.normal(size=(N, 2))
    targets[3] += label
    return ShapeData(inputs[:, :, :size, :size], targets, split=split(N, part), seed=seed, batch=batch)


def train(out, data=None, hidden=(5,), epochs=2, learning_rate=0.01, seed=0, **options):
    net = partial(MLP, first=8, hidden=list(hidden))
    data = shapes() if data is None else data
    return fit(net, data, epochs=epochs, learning_rate=learning_rate, seed=seed, out=out, **options)


@pytest.fixture(scope="module")
def last(tmp_path_factory):
    out = tmp_path_factory.mktemp("run")
    train(out, chosen=CHOSEN)
    return out / "last.ckpt"


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"data": shapes(part=1)}, "split was 15 train, 3 test, 2 validation, #.*, now 15 train"),
        ({"data": shapes(label=1.0)}, r"targets was 20 × 2, mean .*, now 20 × 2, mean "),
        ({"data": shapes(label=1.0), "chosen": CHOSEN}, r"but targets was 20 × 2, mean .*, now 20 × 2, mean "),
        ({"chosen": {**CHOSEN, "data.targets": "raw"}}, "but data.targets was standardised, now raw;"),
        ({"data": shapes(scale=2.0), "chosen": CHOSEN}, r"inputs was 20 × 1 × 6 × 6, mean .*, now 20"),
        ({"hidden": (7,)}, "net was MLP #.*, now MLP #"),
        ({"learning_rate": 0.02, "chosen": {"net.learning_rate": 0.02}}, "net.learning_rate was 0.01, now 0.02"),
        ({"data": shapes(batch=4)}, "batch was 8, now 4"),
        ({"data": shapes(scale=2.0)}, r"inputs was 20 × 1 × 6 × 6, mean .*, now 20 × 1 × 6 × 6"),
        ({"data": shapes(size=5), "chosen": {"latent.keep": 5}}, "latent.keep was 6, now 5"),
        ({"seed": 1}, "seed was 0, now 1"),
    ],
)
def test_what_differs_is_named(last, tmp_path, changed, message):
    with pytest.raises(InputError, match=message) as caught:
        train(tmp_path, ckpt_path=last, epochs=4, **changed)
    assert "begin anew without ckpt_path" in str(caught.value)
    assert "\n" not in str(caught.value)


def test_more_epochs_are_no_difference(last, tmp_path):
    assert train(tmp_path, ckpt_path=last, epochs=4, chosen={"latent.keep": 6})["test/mse"] > 0
