"""What TensorBoard gets of a training run: curves over epochs, the same in one chart, a line in HPARAMS."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from lightning.pytorch.loggers import TensorBoardLogger
from lightning.pytorch.utilities import rank_zero_only
from torch.utils.tensorboard.summary import hparams


class Curves(TensorBoardLogger):
    """Scalars over epochs, counted from 1 as `best_epoch` is, with the run's choices and a chart for each score.

    Args:
        folder: of the event files.
        done: epochs behind a resumed run; what an interrupted one wrote later than these is not shown.
    """

    def __init__(self, folder: Path, done: int = 0):
        super().__init__(folder, "", "", default_hp_metric=False, purge_step=done + 1 if done else None)
        self.first = done + 1

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
        _, _, end = hparams({}, {})
        self.experiment._get_file_writer().add_summary(end)
        self.finalize("success")
