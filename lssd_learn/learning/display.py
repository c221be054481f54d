"""What a person sees while a net is trained: the epoch, the validation error, the time left."""

import logging
import time
from typing import cast

import lightning
from rich.console import Console
from rich.progress import Progress

from lssd_learn.progress import LINE, NotebookBar, bar

log = logging.getLogger(__name__)

# Seconds between two updates. An epoch takes a few hundredths, so drawing each would cost more than training it.
BAR = 0.25


class EpochDisplay(lightning.Callback):
    """A bar on standard error or in a notebook; elsewhere a line in the log every ten seconds instead."""

    def __init__(self, monitor: str):
        self.monitor = monitor
        self.bar: Progress | None = None
        self.notebook: NotebookBar | None = None

    def on_train_start(self, trainer: lightning.Trainer, pl_module: lightning.LightningModule) -> None:
        if not trainer.is_global_zero:
            return
        self.first, self.start = trainer.current_epoch, time.monotonic()
        self.shown = self.start
        console = Console(stderr=True)
        if console.is_terminal:
            self.bar = bar(console, auto_refresh=False)
            self.task = self.bar.add_task("epochs", total=trainer.max_epochs, completed=self.first)
            self.bar.start()
        elif console.is_jupyter:
            self.notebook = NotebookBar("epochs", cast(int, trainer.max_epochs))

    def on_train_epoch_end(self, trainer: lightning.Trainer, pl_module: lightning.LightningModule) -> None:
        now, done = time.monotonic(), trainer.current_epoch + 1
        if not trainer.is_global_zero or (
            now - self.shown < (BAR if self.bar or self.notebook else LINE) and done != trainer.max_epochs
        ):
            return
        self.shown = now
        value = f"{self.monitor} {float(trainer.callback_metrics[self.monitor]):.4g}"
        if self.bar:
            self.bar.update(self.task, completed=done, description=f"epochs, {value}", refresh=True)
        elif self.notebook:
            self.notebook.update(done, value)
        else:
            left = (now - self.start) / (done - self.first) * (cast(int, trainer.max_epochs) - done)
            log.info("epoch %d/%d, %s, %.0f s left", done, trainer.max_epochs, value, left)

    def on_train_end(self, trainer: lightning.Trainer, pl_module: lightning.LightningModule) -> None:
        self._stop()

    def on_exception(
        self, trainer: lightning.Trainer, pl_module: lightning.LightningModule, exception: BaseException
    ) -> None:
        self._stop()

    def _stop(self) -> None:
        if self.bar:
            self.bar.stop()
            self.bar = None
