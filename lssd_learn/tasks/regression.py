"""`task=regression`: read the parameters of every shape, from its operators or its points."""

import logging
from collections.abc import Sequence
from pathlib import Path

from lssd_learn.errors import InputError
from lssd_learn.learning import Regression, mean_reference, operator_features, ridge_reference
from lssd_learn.tasks.pieces import Pieces
from lssd_learn.tasks.training import plan, train

log = logging.getLogger(__name__)


def run(pieces: Pieces, out: Path, epochs: int, milestones: Sequence[int] = ()) -> dict[str, float]:
    """Train a net on the parameters of the collection; say beside it what closed-form references reach on the split.

    Args:
        epochs: passes over the training split.
        milestones: epochs up to which the best is scored too.

    Returns:
        The metrics of `lssd_learn.learning.fit` and reference/{mean,ridge}/{mse,l1} on the same split.
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
    net = f"{pieces.choices['net']}, epoch {metrics['best_epoch']}"
    twins = pieces.data.twins != "none"
    whom = "the twins of test shapes, references on the shapes" if twins else f"{len(parts.test)} shapes"
    log.info("test error (MSE, L1) on %s:", whom)
    log.info("  %-28s %.5f  %.4f", net, metrics["test/mse"], metrics["test/l1"])
    log.info("  %-28s %.5f  %.4f", "ridge on the operators", ridge.mse, ridge.l1)
    log.info("  %-28s %.5f  %.4f", "mean of the training split", mean.mse, mean.l1)
    return metrics | {
        "reference/mean/mse": mean.mse,
        "reference/mean/l1": mean.l1,
        "reference/ridge/mse": ridge.mse,
        "reference/ridge/l1": ridge.l1,
    }
