import math
import signal

import lightning
import numpy as np
import pytest
import torch
from tensorboard.backend.event_processing.event_accumulator import EventAccumulator
from trained import TINY, Record, numbers

from lssd_learn.errors import InputError
from lssd_learn.learning import Regression, ShapeData, evaluate, load, split
from lssd_learn.nets import CNN, MLP, PointNet


def test_the_generator_and_the_threads_of_the_caller_are_left_as_they_were(train):
    torch.manual_seed(5)
    expected = torch.rand(3)
    torch.manual_seed(5)
    torch.set_num_threads(2)
    train()
    assert torch.equal(torch.rand(3), expected)
    assert torch.get_num_threads() == 2
    with pytest.raises(InputError, match="no epoch had a finite"):
        train(learning_rate=1e30)
    assert torch.get_num_threads() == 2


def test_metrics_are_flat_numbers(train):
    metrics = train()
    assert set(metrics) == {
        *(f"{part}/{name}" for part in ("train", "validation", "test") for name in Regression.names),
        "generalisation_error",
        "best_epoch",
        "seconds/fit",
    }
    assert all(isinstance(value, int | float) and math.isfinite(value) for value in metrics.values())
    assert metrics["generalisation_error"] == metrics["test/mse"] - metrics["train/mse"]


@pytest.mark.parametrize("net", [CNN, MLP])
def test_it_learns(train, data, net):
    metrics = train(net, epochs=100)
    assert metrics["test/mse"] < 0.1 * data.targets.var()


def test_it_learns_from_clouds(train):
    generator = np.random.default_rng(0)
    scales = generator.uniform(0.5, 1.5, (30, 3))
    clouds = generator.normal(size=(64, 3)) * scales[:, None]
    shapes = ShapeData(clouds, scales, split=split(30, 0), seed=0)
    assert train(PointNet, shapes, epochs=100, learning_rate=0.005)["test/mse"] < 0.1 * scales.var()


def test_the_same_seed_gives_the_same_metrics_and_zero_is_a_seed(train):
    metrics = [numbers(train(out=str(i), seed=seed)) for i, seed in enumerate((0, 0, 1))]
    assert metrics[0] == metrics[1] != metrics[2]


def test_the_selected_epoch_is_the_best(train, data, tmp_path):
    record = Record()
    metrics = train(epochs=30, learning_rate=0.3, trainer_options={"callbacks": [record]})
    best = int(np.argmin(record.values))
    assert 0 < best < 29  # or nothing was selected
    assert metrics["best_epoch"] == best + 1
    chosen = load(tmp_path / "run" / "best.ckpt", TINY)
    assert all(torch.equal(tensor, record.weights[best][name]) for name, tensor in chosen.state_dict().items())
    assert metrics["validation/relative_mse"] == pytest.approx(min(record.values), rel=1e-5)
    assert evaluate(chosen, data).items() <= metrics.items()


def test_a_milestone_is_the_run_that_ends_there(train):
    short = numbers(train(out="short", epochs=7))
    long = train(out="long", epochs=20, milestones=(7, 500))
    assert {name: long[f"{name}@7"] for name in short} == short
    assert not any("@500" in name for name in long)


def test_checkpoints_hold_tensors_and_plain_containers_only(train, tmp_path):
    train(milestones=(3,), trainer_options={"callbacks": [Record()]})
    for name in ("best.ckpt", "last.ckpt"):
        assert "state_dict" in torch.load(tmp_path / "run" / name, weights_only=True)
    assert not list((tmp_path / "run").glob("*.partial"))


def test_a_checkpoint_reads_raw_operators(train, data, tmp_path):
    metrics = train(CNN, epochs=20)
    regression = load(tmp_path / "run" / "best.ckpt", CNN)
    operators, parameters = data.part("test")
    with torch.no_grad():
        assert ((regression(operators) - parameters) ** 2).mean() == pytest.approx(metrics["test/mse"], rel=1e-5)
    lightnings = Regression.load_from_checkpoint(tmp_path / "run" / "best.ckpt", net=CNN(1, 10, 3), weights_only=True)
    assert torch.equal(lightnings.mean, data.mean)


def test_a_net_is_left_with_the_best_weights(train, data, tmp_path):
    torch.manual_seed(3)
    net = TINY(1, 10, 3)
    train(net, epochs=20, learning_rate=0.1)
    chosen = load(tmp_path / "run" / "best.ckpt", TINY).net
    assert all(torch.equal(a, b) for a, b in zip(net.parameters(), chosen.parameters(), strict=True))


def test_tensorboard(train, tmp_path):
    metrics = train(hyperparameters={"net": "mlp"}, references={"ridge": 0.5})
    events = EventAccumulator(str(tmp_path / "run" / "tensorboard"))
    events.Reload()
    scores = {f"{part}/{name}" for part in ("train", "validation", "test") for name in Regression.names}
    assert set(events.Tags()["scalars"]) == {*scores, "test/mse/ridge"}
    assert [event.step for event in events.Scalars("validation/mse")] == [1, 2, 3, 4, 5, 6]
    assert events.Scalars("test/mse")[-1].value == pytest.approx(metrics["test/mse"])
    assert "_hparams_/session_start_info" in events.summary_metadata


def test_batches_of_the_evaluation_change_no_score(train, collection, tmp_path):
    train()
    chosen = load(tmp_path / "run" / "best.ckpt", TINY)
    whole, parts = (ShapeData(*collection, split=split(60, 0), seed=0, batch=batch) for batch in (45, 4))
    assert evaluate(chosen, whole) == pytest.approx(evaluate(chosen, parts), rel=1e-5)
    record = Record()
    metrics = train(shapes=parts, epochs=1, trainer_options={"callbacks": [record]})
    assert metrics["validation/relative_mse"] == pytest.approx(record.values[0], rel=1e-5)


@pytest.mark.filterwarnings("ignore:.*LeafSpec:FutureWarning")  # between Lightning 2.6 and torch 2.13
def test_trainer_test_says_the_same(train, data, tmp_path):
    metrics = train()
    trainer = lightning.Trainer(
        accelerator="cpu", devices=1, logger=False, enable_progress_bar=False, enable_checkpointing=False
    )
    (result,) = trainer.test(load(tmp_path / "run" / "best.ckpt", TINY), datamodule=data, verbose=False)
    assert result["test/mse"] == pytest.approx(metrics["test/mse"], rel=1e-5)


def test_threads_are_given_back(train):
    before = torch.get_num_threads()
    train(epochs=1)
    assert torch.get_num_threads() == before


def test_divergence_is_an_error_and_leaves_no_old_best(train, tmp_path):
    train()
    with pytest.raises(InputError, match="no epoch had a finite validation/relative_mse: learning_rate 1e\\+30"):
        train(learning_rate=1e30)
    assert not (tmp_path / "run" / "best.ckpt").exists()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"epochs": 0}, "epochs=0: expected a whole number, 1 or more"),
        ({"milestones": ["x"]}, "milestones=x: expected a whole number"),
        ({"learning_rate": -1.0}, "learning_rate=-1.0: expected a number above 0"),
        ({"learning_rate": math.nan}, "learning_rate=nan: expected a number above 0"),
        ({"seed": 2**70}, "seed=.*: expected a whole number, 0 to"),
        ({"trainer_options": {"accelerator": "cuda"}}, "^trainer: "),
        ({"trainer_options": {"acelerator": "cpu"}}, "trainer: .*acelerator"),
        ({"ckpt_path": "nowhere.ckpt"}, "nowhere.ckpt: no such file; expected a checkpoint"),
    ],
)
def test_errors(train, options, message):
    if options.get("trainer_options") == {"accelerator": "cuda"} and torch.cuda.is_available():
        pytest.skip("there is a GPU")
    with pytest.raises(InputError, match=message):
        train(**options)


def test_an_interrupt_stays_one_and_signals_are_heard_again(train, tmp_path):
    class Impatient(lightning.Callback):
        def on_train_epoch_end(self, trainer, pl_module):
            signal.raise_signal(signal.SIGINT)

    # A process that a shell started in the background ignores interrupts.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with pytest.raises(KeyboardInterrupt):
            train(trainer_options={"callbacks": [Impatient()]})
        assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    finally:
        signal.signal(signal.SIGINT, before)
    assert not (tmp_path / "run" / "best.ckpt").exists()


def test_checkpoints_that_do_not_fit(train, collection, tmp_path):
    train()
    last, best, broken = tmp_path / "run" / "last.ckpt", tmp_path / "run" / "best.ckpt", tmp_path / "broken.ckpt"
    broken.write_bytes(last.read_bytes()[:3000])
    with pytest.raises(InputError, match="net was MLP #.*, now CNN #"):
        train(CNN, ckpt_path=last)
    with pytest.raises(InputError, match=r"resume from a last\.ckpt"):
        train(ckpt_path=best)
    with pytest.raises(InputError, match="6 epochs behind it, more than the 4"):
        train(ckpt_path=last, epochs=4)
    with pytest.raises(InputError, match="broken.ckpt: expected a checkpoint, but it cannot be read: it is damaged"):
        train(ckpt_path=broken)
    with pytest.raises(InputError, match="another net than this CNN"):
        load(best, CNN)
    other = ShapeData(*collection, split=split(60, 1), seed=0)
    with pytest.raises(InputError, match=r"split was .*, now "):
        train(ckpt_path=last, shapes=other)
    smaller = ShapeData(collection[0][:, :, :8, :8], collection[1], split=split(60, 0), seed=0)
    with pytest.raises(InputError, match=r"inputs was 60 × 1 × 10 × 10, .*, now 60 × 1 × 8 × 8"):
        train(ckpt_path=last, shapes=smaller)
    torch.save([1, 2], broken)
    with pytest.raises(InputError, match="not a checkpoint of a training run"):
        load(broken, CNN)
