"""The checkpoint a killed run is resumed from."""

from pathlib import Path

import lightning
from lightning.pytorch.callbacks import Checkpoint


class LastCheckpoint(Checkpoint):
    """Overwrites `path` every so many epochs and after the last one.

    Lightning's ModelCheckpoint leaves the last epoch out unless it is a multiple of `every`, and warns about a
    directory that holds an earlier checkpoint, as that of a resumed run does.
    """

    def __init__(self, path: Path, every: int):
        self.path, self.every = path, every

    def on_train_epoch_end(self, trainer: lightning.Trainer, pl_module: lightning.LightningModule) -> None:
        done = trainer.current_epoch + 1
        if done % self.every == 0 or done == trainer.max_epochs:
            trainer.save_checkpoint(self.path)
