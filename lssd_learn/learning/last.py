"""The checkpoint a killed run is resumed from."""

import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import lightning
from lightning.pytorch.callbacks import Checkpoint

from lssd_learn.learning.same import MADE_WITH

SECONDS = 60.0  # of training that a kill may cost at most, beside the epoch it falls into


class LastCheckpoint(Checkpoint):
    """Overwrites `path` after the first epoch, then every so many epochs or a minute, and after the last one.

    Lightning's ModelCheckpoint leaves the last epoch out unless it is a multiple of `every`, and warns about a
    directory that holds an earlier checkpoint, as that of a resumed run does.

    Args:
        path: the file.
        every: epochs.
        made: what the run is made with, see `same.py`; the file holds it.
    """

    def __init__(self, path: Path, every: int, made: Mapping[str, Any]):
        self.path, self.every, self.made = path, every, dict(made)
        self.written: float | None = None  # when this run last wrote it

    def on_train_epoch_end(self, trainer: lightning.Trainer, pl_module: lightning.LightningModule) -> None:
        done, now = trainer.current_epoch + 1, time.monotonic()
        late = self.written is None or now - self.written >= SECONDS
        # The clock of one process alone decides: all of them take part in the writing.
        late = trainer.strategy.broadcast(late)
        if late or done % self.every == 0 or done == trainer.max_epochs:
            for logger in trainer.loggers:  # a run that goes on from here finds its curves up to here
                logger.save()
            trainer.save_checkpoint(self.path)
            self.written = now

    def on_save_checkpoint(
        self, trainer: lightning.Trainer, pl_module: lightning.LightningModule, checkpoint: dict[str, Any]
    ) -> None:
        checkpoint[MADE_WITH] = self.made
