"""Training without gradient descent: a net that solves itself, round after round, of which the best is kept.

It leaves what a training by Lightning leaves: curves over the rounds, and a best.ckpt that `load` reads.
"""

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, cast

import lightning
import torch
from torch import Tensor

from lssd_learn.learning.best import write_whole
from lssd_learn.learning.curves import Curves
from lssd_learn.learning.datamodule import ShapeData
from lssd_learn.learning.module import Learner
from lssd_learn.nets import Solvable
from lssd_learn.progress import track


def solve(
    learner: Learner, data: ShapeData, path: Path, logger: Curves, carries: Mapping[str, Any] | None = None
) -> None:
    """Go through the rounds of `learner.net` and write the one that is best on validation to `path`.

    Args:
        learner: a net with `solve` (see `lssd_learn.nets.KernelMachine`) and its scores; nothing is subtracted from
            the inputs.
        data: the shapes.
        path: of best.ckpt.
        logger: gets every score of train and validation after each round.
        carries: what else the file holds, as for `fit`.
    """
    parts = {name: data.part(name) for name in ("train", "validation")}
    monitor = f"validation/{learner.minimised}"
    path.unlink(missing_ok=True)  # of an earlier run
    lowest = math.inf
    net = cast(Solvable, learner.net)
    given: dict[str, Any] = {name: (inputs, learner.aims(targets)) for name, (inputs, targets) in parts.items()}
    if data.blocks is not None:
        given["blocks"] = data.blocks[torch.from_numpy(data.split.train)]
    rounds = net.solve(**given)
    for epoch, predictions in enumerate(track(rounds, "rounds", net.rounds), start=1):
        scores = {
            f"{name}/{score}": float(value)
            for (name, (_, targets)), prediction in zip(parts.items(), predictions, strict=True)
            for score, value in zip(learner.names, _scores(learner, prediction, targets), strict=True)
        }
        logger.log_metrics(scores, epoch)
        if scores[monitor] < lowest:
            lowest = scores[monitor]
            # The net makes new tensors every round, so these stay what they are.
            best = {"epoch": epoch, "value": lowest, "state_dict": learner.state_dict()}
    if lowest < math.inf:
        write_whole(
            {
                **(carries or {}),
                **best,
                "milestones": {},
                "hyper_parameters": dict(learner.hparams),
                "pytorch-lightning_version": lightning.__version__,
            },
            path,
        )


def _scores(learner: Learner, outputs: Tensor, targets: Tensor) -> Sequence[Tensor]:
    """Of what the net gives; numbers are compared in its precision, labels as they are."""
    prediction = learner.told(outputs)
    return learner.scores(prediction, targets.to(prediction) if targets.is_floating_point() else targets)
