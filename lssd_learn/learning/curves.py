"""What TensorBoard gets of a training run: curves over epochs, the same in one chart, a line in HPARAMS."""

import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from lightning.pytorch.loggers import TensorBoardLogger
from lightning.pytorch.utilities import rank_zero_only
from tensorboard.compat.proto.summary_pb2 import Summary  # pyright: ignore[reportAttributeAccessIssue] made at run time
from torch.utils.tensorboard.summary import hparams

SECONDS = 1.0  # that curves may be behind


class Curves(TensorBoardLogger):
    """Scalars over epochs, counted from 1 as `best_epoch` is, with the run's choices and a chart for each score.

    Args:
        folder: of the event files.
        done: epochs behind a resumed run; what an interrupted one wrote later than these is not shown.
    """

    def __init__(self, folder: Path, done: int = 0):
        super().__init__(folder, "", "", default_hp_metric=False, purge_step=done + 1 if done else None)
        self.first = done + 1
        self._waiting: list[tuple[Summary, int | None]] = []
        self._written = time.monotonic()

    @rank_zero_only
    def log_metrics(self, metrics: Mapping[str, float], step: int | None = None) -> None:
        """All of them as one event, and many events at once: the file is written by another thread, and to wake it
        costs more than a step of a small net."""
        values = [Summary.Value(tag=name, simple_value=float(value)) for name, value in metrics.items()]
        self._waiting.append((Summary(value=values), step))
        if time.monotonic() - self._written > SECONDS:
            self._write()

    @rank_zero_only
    def save(self) -> None:
        self._write()
        super().save()

    @rank_zero_only
    def finalize(self, status: str) -> None:
        self._write()
        super().finalize(status)

    def _write(self) -> None:
        for summary, step in self._waiting:
            self.experiment._get_file_writer().add_summary(summary, step)
        self._waiting, self._written = [], time.monotonic()

    @rank_zero_only
    def start(
        self,
        hyperparameters: Mapping[str, Any],
        scores: Sequence[str],
        references: Mapping[str, float],
        epochs: int,
    ) -> None:
        """List the run in HPARAMS, and draw what is known beforehand.

        Args:
            hyperparameters: name → number or text.
            scores: for each, the curves of its name become one chart under CUSTOM SCALARS.
            references: name → what something else reaches in the first score on the test split: a level line
                "test/<score>/<name>" from the first epoch to the last.
            epochs: of the whole run.
        """
        self.hparams.update(hyperparameters)  # for hparams.yaml
        # Without the experiment's own summary, which would be that of the first run of a sweep, TensorBoard finds out
        # which choices differ between the runs, shows those first, and offers every scalar as a column to sort by.
        _, session, _ = hparams(dict(hyperparameters), {})
        self.experiment._get_file_writer().add_summary(session)
        charts = {name: ["Multiline", [rf"(train|validation|test)/{name}(/|$)"]] for name in scores}
        self.experiment.add_custom_scalars({"errors": charts})
        levels = {f"test/{scores[0]}/{name}": value for name, value in references.items()}
        for epoch in (self.first, epochs):
            self.log_metrics(levels, epoch)

    @rank_zero_only
    def finish(self, scores: Mapping[str, float], epochs: int) -> None:
        """Add the scores of the finished run, and say in HPARAMS that it is."""
        self.log_metrics(scores, epochs)
        self._write()
        _, _, end = hparams({}, {})
        self.experiment._get_file_writer().add_summary(end)
        self.finalize("success")
