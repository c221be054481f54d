import numpy as np
import pytest
import torch

from lssd_learn.errors import InputError
from lssd_learn.learning import ShapeData, split
from lssd_learn.learning.batches import Variation


def test_operators(collection, data):
    operators, parameters = collection
    assert (data.channels, data.size, data.outputs) == (1, 10, 3)
    assert (data.inputs.dtype, data.targets.dtype) == (torch.float32, torch.float64)
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


@pytest.mark.parametrize("up", [None, "z"])
def test_only_training_clouds_vary(up):
    generator = np.random.default_rng(0)
    clouds, denser = (generator.normal(size=(20, points, 3)) + 10 * np.arange(20)[:, None, None] for points in (50, 90))
    variation = Variation(0, up, denser)
    data, plain = (
        ShapeData(clouds, np.arange(20.0), split=split(20, 0), seed=0, variation=v) for v in (variation, None)
    )
    for part in ("train", "test", "validation"):
        assert torch.equal(data.part(part)[0], plain.part(part)[0])
    for loader in ("test_dataloader", "val_dataloader"):
        for some, others in zip(getattr(data, loader)(), getattr(plain, loader)(), strict=True):
            assert torch.equal(some[0], others[0])
    for (some, targets), (others, same) in zip(data.train_dataloader(), plain.train_dataloader(), strict=True):
        assert torch.equal(targets, same)
        assert (some != others).any(-1).any(-1).all()
        assert torch.equal((some.mean((1, 2)) / 10).round(), targets)  # points of another shape would lie elsewhere


@pytest.mark.parametrize(
    ("inputs", "variation", "message"),
    [
        (np.zeros((20, 1, 5, 5)), Variation(0, "z"), r"expected clouds to vary, got inputs \(20, 1, 5, 5\)"),
        (np.zeros((20, 9, 3)), Variation(0, "x"), "expected y or z as the axis that is up, got 'x'"),
        (np.zeros((20, 9, 3)), Variation(0, None, np.zeros((20, 8, 3))), r"\(20, 9 or more, 3\), got \(20, 8, 3\)"),
        (np.zeros((20, 9, 3)), Variation(0, None, np.zeros((19, 9, 3))), r"\(20, 9 or more, 3\), got \(19, 9, 3\)"),
        (np.zeros((20, 9, 3)), Variation(0, None, np.full((20, 9, 3), np.inf)), "denser clouds must be finite"),
    ],
)
def test_variations_that_do_not_fit(inputs, variation, message):
    with pytest.raises(InputError, match=message):
        ShapeData(inputs, np.zeros((20, 1)), split=split(20, 0), seed=0, variation=variation)
