"""`task=regression`: read the parameters of every shape, from its operators or its points."""

import logging
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from lightning.pytorch.utilities import rank_zero_only

from lssd_learn.errors import InputError
from lssd_learn.learning import Regression, load, mean_reference, operator_features, predict, ridge_reference
from lssd_learn.learning.scores.parameters import write_errors
from lssd_learn.pieces import Pieces
from lssd_learn.tasks.training import plan, tested_inputs, train

log = logging.getLogger(__name__)


def run(pieces: Pieces, out: Path, epochs: int, milestones: Sequence[int] = ()) -> dict[str, float]:
    """Train a net on the parameters of the collection; say beside it what closed-form references reach on the split.

    Args:
        epochs: passes over the training split.
        milestones: epochs up to which the best is scored too.

    Returns:
        The metrics of `lssd_learn.learning.fit` and reference/{mean,ridge}/{mse,l1} on the same split. The errors of
        each parameter are in parameters.csv.
    """
    parameters = pieces.pipeline.collection.parameters
    if parameters is None:
        why = pieces.pipeline.collection.lacks("parameters")
        raise InputError(f"task=regression: expected shapes with parameters; {why}")
    parts, epochs = plan(pieces, epochs, Regression)
    mean = mean_reference(parameters, parts)
    ridge = ridge_reference(operator_features(pieces.pipeline.operators(pieces.operators)), parameters, parts)

    metrics = train(
        pieces,
        out,
        parameters,
        parts,
        epochs,
        milestones=milestones,
        module=Regression,
        references={"mean": mean.mse, "ridge": ridge.mse},
        carries={"parameters": list(pieces.pipeline.collection.parameter_names)},
    )
    twins = pieces.data.twins != "none"
    whom = "the twins of test shapes, references on the shapes" if twins else f"{len(parts.test)} shapes"
    log.info("test error (MSE, L1; MSE over the variance in training, mean over the parameters) on %s:", whom)
    unit = np.square(np.where(spread := np.std(parameters[parts.train], axis=0), spread, 1))
    for name, mse, l1, relative in (
        (f"{pieces.choices['net']}, epoch {metrics['best_epoch']}",
         *(metrics[f"test/{score}"] for score in Regression.names)),
        ("ridge on the operators", ridge.mse, ridge.l1, np.mean(ridge.errors**2 / unit)),
        ("mean of the training split", mean.mse, mean.l1, np.mean(mean.errors**2 / unit)),
    ):  # fmt: skip
        log.info("  %-28s %.4g  %.4g  %.4g", name, mse, l1, relative)
    if not twins and rank_zero_only.rank == 0:
        reader = load(out / "best.ckpt", pieces.net, Regression)
        errors = {"net": predict(reader, tested_inputs(pieces, parts)) - parameters[parts.test]}
        errors |= {"ridge": ridge.errors, "mean": mean.errors}
        write_errors(list(pieces.pipeline.collection.parameter_names), parameters[parts.test], errors, out)
    return metrics | {
        "reference/mean/mse": mean.mse,
        "reference/mean/l1": mean.l1,
        "reference/ridge/mse": ridge.mse,
        "reference/ridge/l1": ridge.l1,
    }
