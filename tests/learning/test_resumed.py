"""Runs that end the same however they are gone through: by epochs or by batches, in one go or cut and resumed."""

import numpy as np
import pytest
import torch
from tensorboard.backend.event_processing.event_accumulator import EventAccumulator
from trained import TINY, Quiet, Record, numbers

from lssd_learn.learning import Classification, Regression, ShapeData, split
from lssd_learn.learning.batches import Variation
from lssd_learn.nets import CNN, PointNet


@pytest.mark.parametrize("net", [CNN, TINY])
def test_epochs_at_once_are_the_same_as_batch_by_batch(train, tmp_path, net):
    """Lightning is given whole epochs where nobody asks it for something in between: same weights, same curves."""
    steps = train(net, out="steps", epochs=20, trainer_options={"callbacks": [Record()]})
    whole = train(net, out="whole", epochs=20)
    assert numbers(whole) == numbers(steps)
    first, second = (torch.load(tmp_path / out / "last.ckpt", weights_only=True) for out in ("steps", "whole"))
    assert second["global_step"] == first["global_step"]
    for name, tensor in first["state_dict"].items():
        assert torch.equal(second["state_dict"][name], tensor)
    curves = []
    for out in ("steps", "whole"):
        events = EventAccumulator(str(tmp_path / out / "tensorboard"))
        events.Reload()
        names = [f"{part}/{name}" for part in ("train", "validation", "test") for name in Regression.names]
        curves.append([[event.step, event.value] for name in names for event in events.Scalars(name)])
    np.testing.assert_allclose(curves[1], curves[0], rtol=1e-5)


def test_classes_too_are_the_same_by_epochs_and_by_batches(data, train):
    labels = np.arange(len(data.inputs)) % 3
    shapes = ShapeData(data.inputs, labels, split=data.split, seed=0, batch=4)  # whose learning rate rises step by step
    options = {"shapes": shapes, "epochs": 30, "module": Classification}
    steps = train(out="steps", trainer_options={"callbacks": [Quiet()]}, **options)
    assert numbers(train(out="whole", **options)) == numbers(steps)


def test_a_run_goes_on_by_epochs_from_where_it_was_going_batch_by_batch(train, tmp_path):
    options = {"epochs": 12, "learning_rate": 0.1, "checkpoint_every": 5}
    whole = numbers(train(CNN, out="whole", **options))
    train(CNN, out="cut", **options | {"epochs": 5}, trainer_options={"callbacks": [Record()]})
    assert numbers(train(CNN, out="resumed", ckpt_path=tmp_path / "cut" / "last.ckpt", **options)) == whole


def test_a_resumed_run_ends_with_the_same_bits(train, tmp_path):
    options = {"epochs": 12, "learning_rate": 0.1, "checkpoint_every": 5, "milestones": (3, 9)}
    whole = numbers(train(CNN, out="whole", **options))
    with pytest.raises(ConnectionResetError):
        train(CNN, out="cut", trainer_options={"callbacks": [Record(crash_after=7)]}, **options)
    torch.rand(17)  # another process has another global state
    resumed = train(CNN, out="resumed", ckpt_path=tmp_path / "cut" / "last.ckpt", **options)
    assert numbers(resumed) == whole
    finished = train(CNN, out="again", ckpt_path=tmp_path / "resumed" / "last.ckpt", **options)
    assert numbers(finished) == whole


def test_a_resumed_run_sees_the_same_variations(train, tmp_path):
    generator = np.random.default_rng(0)
    clouds, denser = (generator.normal(size=(20, points, 3)) for points in (16, 64))
    shapes = ShapeData(
        clouds, generator.random((20, 2)), split=split(20, 0), seed=0, variation=Variation(0, "z", denser)
    )
    whole = numbers(train(PointNet, shapes, out="whole"))
    with pytest.raises(ConnectionResetError):
        train(PointNet, shapes, out="cut", trainer_options={"callbacks": [Record(crash_after=3)]}, checkpoint_every=1)
    assert numbers(train(PointNet, shapes, out="cut", ckpt_path=tmp_path / "cut" / "last.ckpt")) == whole
    plain = ShapeData(clouds, shapes.targets, split=shapes.split, seed=0)
    assert numbers(train(PointNet, plain, out="plain")) != whole


def test_a_finished_run_can_be_made_longer(train, tmp_path):
    whole = numbers(train(out="whole", epochs=12))
    train(out="first", epochs=7)
    assert numbers(train(out="first", epochs=12, ckpt_path=tmp_path / "first" / "last.ckpt")) == whole


def test_a_run_resumed_in_place_has_one_curve(train, tmp_path):
    with pytest.raises(ConnectionResetError):
        train(epochs=9, checkpoint_every=3, trainer_options={"callbacks": [Record(crash_after=5)]})
    train(epochs=9, ckpt_path=tmp_path / "run" / "last.ckpt")
    events = EventAccumulator(str(tmp_path / "run" / "tensorboard"))
    events.Reload()
    steps = [event.step for event in events.Scalars("validation/mse")]
    assert steps == list(range(1, 10))
