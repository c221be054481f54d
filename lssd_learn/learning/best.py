"""The epoch that is best on the validation split: its weights are kept while training goes on, then written."""

import io
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import lightning
import torch

from lssd_learn.written import whole


class BestWeights(lightning.Callback):
    """Keeps the weights of the best epoch in memory and writes them to `path` when training is over.

    All epochs are run; nothing stops early. What is kept is part of every checkpoint, so a resumed run knows the best
    epoch before it. The file is a Lightning checkpoint of the best weights, with `epoch` (counted from 1), `value` and
    `milestones`: the same three, named `weights`, `epoch` and `value`, for the best epoch up to each milestone.

    Args:
        monitor: the logged value that is to be small.
        path: the file to write.
        milestones: epochs up to which the best is kept as well.
        carries: what else the file holds, tensors and plain containers by name.
    """

    def __init__(
        self, monitor: str, path: Path, milestones: Sequence[int] = (), carries: Mapping[str, Any] | None = None
    ):
        self.monitor, self.path, self.wanted, self.carries = monitor, path, frozenset(milestones), dict(carries or {})
        self.best: dict[str, Any] | None = None
        self.milestones: dict[int, dict[str, Any]] = {}

    def on_fit_start(self, trainer: lightning.Trainer, pl_module: lightning.LightningModule) -> None:
        if trainer.is_global_zero:
            self.path.unlink(missing_ok=True)  # of an earlier run, should this one have nothing to write

    def on_train_epoch_end(self, trainer: lightning.Trainer, pl_module: lightning.LightningModule) -> None:
        epoch, value = trainer.current_epoch + 1, float(trainer.callback_metrics[self.monitor])
        if math.isfinite(value) and (self.best is None or value < self.best["value"]):
            weights = {name: tensor.detach().cpu().clone() for name, tensor in pl_module.state_dict().items()}
            self.best = {"epoch": epoch, "value": value, "weights": weights}
        if epoch in self.wanted and self.best is not None:
            self.milestones[epoch] = self.best

    def on_fit_end(self, trainer: lightning.Trainer, pl_module: lightning.LightningModule) -> None:
        if trainer.is_global_zero and self.best is not None:
            checkpoint = self.carries | {
                "state_dict": self.best["weights"],
                "epoch": self.best["epoch"],
                "value": self.best["value"],
                "milestones": self.milestones,
                "hyper_parameters": dict(pl_module.hparams),
                "pytorch-lightning_version": lightning.__version__,
            }
            write_whole(checkpoint, self.path)
        trainer.strategy.barrier()

    def state_dict(self) -> dict[str, Any]:
        return {"best": self.best, "milestones": self.milestones}

    def load_state_dict(self, state_dict: dict[str, Any]) -> None:
        self.best, self.milestones = state_dict["best"], state_dict["milestones"]


def write_whole(checkpoint: Mapping[str, Any], path: Path) -> None:
    """Write a checkpoint so that a killed run leaves no half of it."""
    buffer = io.BytesIO()
    torch.save(checkpoint, buffer)  # straight to a full disk, it raises what nobody could tell from other faults
    with whole(path) as draft:
        draft.write_bytes(buffer.getbuffer())
