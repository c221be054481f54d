import numpy as np
import pytest
import torch

from lssd_learn.errors import InputError
from lssd_learn.learning import ShapeData, split


def test_operators(collection, data):
    operators, parameters = collection
    assert (data.channels, data.size, data.outputs) == (1, 10, 3)
    assert data.inputs.dtype == data.targets.dtype == torch.float32
    expected = operators[data.split.train].mean(0)
    np.testing.assert_allclose(data.mean, expected, atol=1e-7)
    inputs, targets = data.part("test")
    np.testing.assert_allclose(targets, parameters[data.split.test], atol=1e-7)
    assert sum(len(x) for x, _ in data.train_dataloader()) == len(data.split.train)
    assert torch.equal(torch.cat([x for x, _ in data.test_dataloader()]), inputs)


def test_the_mean_does_not_know_the_test_split(collection):
    operators, parameters = collection
    parts = split(60, 0)
    changed = operators.copy()
    changed[np.concatenate([parts.test, parts.validation])] += 5
    means = [ShapeData(x, parameters, split=parts, seed=0).mean for x in (operators, changed)]
    assert torch.equal(*means)


def test_clouds(tmp_path):
    path = tmp_path / "clouds.npy"
    np.save(path, np.random.default_rng(0).normal(size=(20, 50, 3)))
    data = ShapeData(np.load(path, mmap_mode="r"), torch.rand(20, 4), split=split(20, 0), seed=0)
    assert (data.channels, data.size, data.outputs) == (3, 50, 4)
    assert data.mean.shape == ()
    assert data.mean == 0


def test_labels():
    labels = np.arange(20) % 8
    data = ShapeData(np.zeros((20, 1, 5, 5)), labels, split=split(20, 0), seed=0)
    assert data.targets.dtype == torch.int64
    assert data.outputs == 8


def test_nothing_is_subtracted_where_nothing_is_asked_for(collection):
    assert ShapeData(*collection, split=split(60, 0), seed=0, standardise="none").mean == 0


@pytest.mark.parametrize(
    ("inputs", "targets", "options", "message"),
    [
        (np.zeros((20, 5, 5)), np.zeros((20, 1)), {}, r"got \(20, 5, 5\)"),
        (np.zeros((19, 1, 5, 5)), np.zeros((20, 1)), {}, "do not fit"),
        (np.zeros((20, 1, 5, 5)), np.full((20, 1), np.nan), {}, "targets must be finite, 20 values"),
        (np.zeros((20, 1, 5, 5)), np.zeros((20, 1)), {"standardise": "scale"}, "auto, mean or none"),
        (np.zeros((20, 1, 5, 5)), np.zeros((20, 1)), {"batch": 0}, "batch=0: expected a whole number, 1 or more"),
        (np.zeros((20, 1, 5, 5)), np.zeros((20, 1)), {"seed": -1}, "seed=-1: expected a whole number, 0 or more"),
    ],
)
def test_errors(inputs, targets, options, message):
    with pytest.raises(InputError, match=message):
        ShapeData(inputs, targets, split=split(20, 0), **{"seed": 0, **options})
