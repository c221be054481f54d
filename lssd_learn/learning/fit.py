"""Train a net, choose the epoch on the validation split, say how good it is: what tasks and notebooks call."""

import logging
import signal
import threading
import time
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, cast

import lightning
import torch
from lightning.fabric.utilities.exceptions import MisconfigurationException
from torch import nn

from lssd_learn.errors import MOST_SEED, InputError, check_positive, check_whole
from lssd_learn.learning.best import BestWeights
from lssd_learn.learning.checkpoint import read, restore
from lssd_learn.learning.curves import Curves
from lssd_learn.learning.datamodule import ShapeData
from lssd_learn.learning.display import EpochDisplay
from lssd_learn.learning.evaluation import evaluate
from lssd_learn.learning.last import LastCheckpoint
from lssd_learn.learning.module import Learner
from lssd_learn.learning.regression import Regression
from lssd_learn.learning.same import check_same, made_with
from lssd_learn.learning.solve import solve
from lssd_learn.nets import Solvable, is_solved

log = logging.getLogger(__name__)

# Options of Lightning's Trainer that leave it nothing to do from batch to batch; None is any.
PLAIN: Mapping[str, tuple | None] = {
    "accelerator": None, "devices": (1, "1"), "num_nodes": (1,), "strategy": ("auto",),
    "precision": (None, "32-true", 32), "gradient_clip_val": (None,), "gradient_clip_algorithm": None,
    "accumulate_grad_batches": (1,),
}  # fmt: skip


def fit(
    net: nn.Module | Callable[..., nn.Module],
    data: ShapeData,
    *,
    epochs: int,
    learning_rate: float | None,
    seed: int,
    out: str | Path,
    trainer_options: Mapping[str, Any] | None = None,
    ckpt_path: str | Path | None = None,
    milestones: Sequence[int] = (),
    checkpoint_every: int = 50,
    hyperparameters: Mapping[str, Any] | None = None,
    references: Mapping[str, float] | None = None,
    carries: Mapping[str, Any] | None = None,
    chosen: Mapping[str, Any] | None = None,
    module: type[Learner] = Regression,
    threads: int = 1,
) -> dict[str, float]:
    """Train for all `epochs`, then score the weights of the epoch that was best on the validation split.

    Leaves in `out`: best.ckpt (see `load`), last.ckpt (to resume from) and tensorboard/.

    Args:
        net: the class of a net or a `functools.partial` of it, built for `data` after the seed is set; or a net, which
            is trained as it is and left with the best weights. What it gives is in the scale that `Regression` learns
            parameters in; in their own units `load` gives them.
        data: the shapes.
        epochs: passes over the training split, those before a resumption included.
        learning_rate: of Adam. A net that is solved in closed form needs none: it goes through its own rounds, which
            count as epochs, on the CPU; `epochs`, `milestones` and `trainer_options` are then not used, and there is
            nothing to go on from.
        seed: of torch's global generator, from which the weights start. The order of the batches is the data's.
        out: the directory to write to, made if need be.
        trainer_options: further arguments of `lightning.Trainer`: accelerator, devices, strategy, precision, …
        ckpt_path: a last.ckpt to go on from; on CPU the metrics are then those of an uninterrupted run to the last bit.
        milestones: epochs for which the best epoch up to there is scored too, as "test/mse@500" and so on; those beyond
            `epochs` are left out.
        checkpoint_every: epochs between two writings of last.ckpt, or fewer: a minute of training too is enough.
        hyperparameters: what TensorBoard's HPARAMS tab shows of this run beside learning rate, epochs and seed: numbers
            and texts.
        references: name → what something else reaches in the first score on the test split; level lines in TensorBoard.
        carries: what else best.ckpt is to hold, such as the latent space the operators belong to.
        chosen: what else the weights depend on, plain values by the names that a user knows. last.ckpt holds them; one
            that was made with others, or with another split, net, learning rate, batch, seed, other inputs or targets,
            is not gone on from.
        module: what is learnt.
        threads: of torch, while this runs. One is fastest for nets as small as these, and leaves the other cores to
            other runs: two threads on a busy machine can take twenty times longer.

    Returns:
        Flat numbers: every score of train, validation and test (mean squared and mean absolute error for a regression:
        "test/mse", "test/l1", …), "generalisation_error" (test − train of the first score), "best_epoch" (from 1),
        all at the selected weights; the same with "@500" for a milestone; "seconds/fit" of this call.

    Raises:
        InputError: arguments out of range, trainer options Lightning refuses, a checkpoint that does not fit, or no
            epoch with a finite validation score.
    """
    for name, value in (("epochs", epochs), ("checkpoint_every", checkpoint_every), ("threads", threads)):
        check_whole(name, value, 1)
    for milestone in milestones:
        check_whole("milestones", milestone, 1)
    if not (solved := is_solved(net)):
        check_positive("learning_rate", learning_rate)
    elif ckpt_path is not None:
        raise InputError(f"ckpt_path={ckpt_path}: this net is solved anew in its rounds and goes on from no checkpoint")
    check_whole("seed", seed, 0, MOST_SEED)
    start, out = time.perf_counter(), Path(out)
    out.mkdir(parents=True, exist_ok=True)
    with _state_of_its_own(seed, threads):
        shape = {"channels": data.channels, "size": data.size, "outputs": data.outputs}
        learner = module(
            net if isinstance(net, nn.Module) else net(**shape), learning_rate, None if solved else data.mean
        )
        learner.hparams.update(shape)
        learner.adapt_to(data.part("train")[1], data.standardise_targets)
        if solved:
            epochs = cast(Solvable, learner.net).rounds
        made = made_with(learner, data, learning_rate, seed, chosen or {})
        done = 0 if ckpt_path is None else _check_resumable(ckpt_path, learner, epochs, made)

        monitor, best = f"validation/{learner.minimised}", out / "best.ckpt"
        logger = Curves(out / "tensorboard", done)
        shown = {"learning_rate": learning_rate, "epochs": epochs, "seed": seed, **(hyperparameters or {})}
        logger.start(shown, learner.names, references or {}, epochs)
        options = dict(trainer_options or {})
        callbacks = [
            *options.pop("callbacks", ()),
            BestWeights(monitor, best, [m for m in milestones if m <= epochs], carries),
            LastCheckpoint(out / "last.ckpt", checkpoint_every, made),
            EpochDisplay(monitor),
        ]
        defaults = {
            "accelerator": "cpu",
            "devices": 1,
            "enable_progress_bar": False,
            "enable_model_summary": False,
            "enable_autolog_hparams": False,
            "num_sanity_val_steps": 0,
            "log_every_n_steps": 1,  # no step logs anything, but Lightning warns where an epoch is shorter than this
        }
        if solved:
            solve(learner, data, best, logger, carries)
        else:
            # Where nothing is asked for that Lightning does from batch to batch, it is given whole epochs.
            data.by_epochs = _is_plain(options)
            learner.automatic_optimization = not data.by_epochs
            if data.by_epochs:
                options["limit_val_batches"] = 0
            with _calm_lightning():
                trainer = _trainer(max_epochs=epochs, logger=logger, callbacks=callbacks, **(defaults | options))
                trainer.fit(learner, datamodule=data, ckpt_path=ckpt_path, weights_only=True)
        if not best.exists():
            cause = "" if solved else f": learning_rate {learning_rate} is too high for these inputs"
            raise InputError(f"no {'round' if solved else 'epoch'} had a finite {monitor}{cause}")
        metrics = _score(best, learner, data)

    # train/ and validation/ are curves already.
    tests = {name: value for name, value in metrics.items() if name.startswith("test/") and "@" not in name}
    logger.finish(tests, epochs)
    log.info("trained %d epochs, best %d: %s", epochs, metrics["best_epoch"], best)
    return metrics | {"seconds/fit": time.perf_counter() - start}


@contextmanager
def _state_of_its_own(seed: int, threads: int) -> Iterator[None]:
    """torch seeded and on so many threads in here; outside, both are as they were."""
    before = torch.get_num_threads()
    there = range(torch.cuda.device_count()) if torch.cuda.is_initialized() else ()
    with torch.random.fork_rng(devices=there):
        torch.manual_seed(seed)
        torch.set_num_threads(threads)
        try:
            yield
        finally:
            torch.set_num_threads(before)


def _score(path: Path, learner: Learner, data: ShapeData) -> dict[str, float]:
    """Metrics of the selected weights and of those of each milestone. Leaves `learner` with the selected weights."""
    # Read back from the file: with processes of their own, the training ones took the callback's memory with them.
    checkpoint = read(path)
    first = learner.names[0]
    metrics: dict[str, float] = {}
    for milestone, kept in [*checkpoint["milestones"].items(), (None, checkpoint)]:
        learner.load_state_dict(kept["weights"] if milestone else kept["state_dict"])
        scores = evaluate(learner, data)
        scores["generalisation_error"] = scores[f"test/{first}"] - scores[f"train/{first}"]
        scores["best_epoch"] = kept["epoch"]
        metrics |= {f"{name}@{milestone}" if milestone else name: value for name, value in scores.items()}
    return metrics


def _check_resumable(path: str | Path, learner: Learner, epochs: int, made: Mapping[str, Any]) -> int:
    """The epochs the checkpoint has behind it, if this run can go on from it."""
    checkpoint = read(path)
    if "optimizer_states" not in checkpoint:
        raise InputError(f"{path} holds weights only: resume from a last.ckpt")
    check_same(path, checkpoint, made)
    if checkpoint["epoch"] + 1 > epochs:
        raise InputError(f"{path} has {checkpoint['epoch'] + 1} epochs behind it, more than the {epochs} asked for")
    mean = learner.mean
    restore(learner, checkpoint, path)
    if not torch.equal(mean, learner.mean):
        raise InputError(f"{path} comes from another latent space, other shapes or another split than these")
    return checkpoint["epoch"] + 1


def check_trainer(options: Mapping[str, Any]) -> None:
    """Refuse what Lightning's Trainer would, such as a GPU that is not there, before any long work.

    Raises:
        InputError: names what it says.
    """
    with _calm_lightning():
        _trainer(**{"logger": False, "enable_checkpointing": False, "enable_progress_bar": False,
            "enable_model_summary": False, "max_epochs": 1, **options})  # fmt: skip


def _is_plain(options: Mapping[str, Any]) -> bool:
    return all(name in PLAIN and ((some := PLAIN[name]) is None or value in some) for name, value in options.items())


def _trainer(**options: Any) -> lightning.Trainer:
    for name in ("num_nodes", "accumulate_grad_batches"):
        check_whole(f"trainer.{name}", options.get(name, 1), 1)
    if options.get("gradient_clip_val") is not None:
        check_positive("trainer.gradient_clip_val", options["gradient_clip_val"])
    try:
        return lightning.Trainer(**options)
    except (TypeError, ValueError, MisconfigurationException) as error:
        raise InputError(f"trainer: {str(error).splitlines()[0]}") from None


@contextmanager
def _calm_lightning() -> Iterator[None]:
    """Without Lightning's advertisements in the log, and the one warning no setting avoids; Ctrl-C stays Ctrl-C."""
    logger = logging.getLogger("lightning.pytorch")
    level = logger.level
    in_main = threading.current_thread() is threading.main_thread()  # signals are its business alone
    interrupt = signal.getsignal(signal.SIGINT) if in_main else None
    logger.setLevel(logging.WARNING)
    try:
        with warnings.catch_warnings():
            # Lightning 2.6 compares with a class that torch 2.13 deprecates.
            warnings.filterwarnings("ignore", r".*LeafSpec", FutureWarning)
            yield
    except SystemExit as end:
        # Lightning makes an exit of it, and has further signals ignored.
        if isinstance(end.__context__, KeyboardInterrupt):
            raise KeyboardInterrupt from None
        raise
    finally:
        if interrupt is not None:
            signal.signal(signal.SIGINT, interrupt)
        logger.setLevel(level)
