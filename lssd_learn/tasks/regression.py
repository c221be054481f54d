"""`task=regression`: read the parameters of every shape, from its operators or its points."""

import logging
from collections.abc import Sequence
from pathlib import Path

from lightning.pytorch.utilities import rank_zero_only

from lssd_learn import nets
from lssd_learn.errors import InputError, check_whole
from lssd_learn.learning import ShapeData, Split, fit, mean_reference, operator_features, ridge_reference, split
from lssd_learn.tasks.overview import write_overview
from lssd_learn.tasks.pieces import Pieces

log = logging.getLogger(__name__)


def run(pieces: Pieces, out: Path, epochs: int, milestones: Sequence[int] = ()) -> dict[str, float]:
    """Train a net on the parameters of the collection; say beside it what closed-form references reach on the split.

    Args:
        epochs: passes over the training split.
        milestones: epochs up to which the best is scored too.

    Returns:
        The metrics of `lssd_learn.learning.fit` and reference/{mean,ridge}/{mse,l1} on the same split.
    """
    collection = pieces.pipeline.collection
    if collection.parameters is None:
        raise InputError("task=regression: expected shapes with parameters; this collection has none (see labels.csv)")
    # What can be wrong is found out before the long work.
    check_whole("task.epochs", epochs, 1)
    check_whole("data.batch", pieces.data["batch"], 1)
    parts = split(len(collection), pieces.seed, pieces.data["split"], pieces.data["protocol"])
    if pieces.debug["epochs"] is not None:
        check_whole("debug.epochs", pieces.debug["epochs"], 1)
        epochs = min(epochs, pieces.debug["epochs"])
    if pieces.debug["overfit"] is not None:
        check_whole("debug.overfit", pieces.debug["overfit"], 1, len(parts.train))
        few = parts.train[: pieces.debug["overfit"]]
        parts = Split(few, few, few)
    operators = pieces.pipeline.operators(pieces.operators)
    mean = mean_reference(collection.parameters, parts)
    ridge = ridge_reference(operator_features(operators), collection.parameters, parts)

    clouds = pieces.pipeline.clouds(pieces.data["points"]) if nets.reads(pieces.net) == "clouds" else None
    data = ShapeData(
        operators if clouds is None else clouds,
        collection.parameters,
        split=parts,
        seed=pieces.seed,
        batch=pieces.data["batch"],
        standardise=pieces.data["standardise"],
    )
    metrics = fit(
        pieces.net,
        data,
        epochs=epochs,
        learning_rate=pieces.learning_rate,
        seed=pieces.seed,
        out=out,
        trainer_options=pieces.trainer,
        ckpt_path=pieces.ckpt_path,
        milestones=milestones,
        hyperparameters=pieces.choices,
        references={"mean": mean.mse, "ridge": ridge.mse},
        # An operator of another latent space is another language: the net travels with the space it was trained in.
        carries={"latent": pieces.pipeline.latent.state()} if clouds is None else {},
    )
    metrics |= {
        "reference/mean/mse": mean.mse,
        "reference/mean/l1": mean.l1,
        "reference/ridge/mse": ridge.mse,
        "reference/ridge/l1": ridge.l1,
    }
    if rank_zero_only.rank == 0:  # of the processes of a distributed run, one
        write_overview(pieces, out, clouds=clouds)
    log.info("test error (MSE, L1) on %d shapes:", len(parts.test))
    log.info(
        "  %-28s %.5f  %.4f",
        f"{pieces.choices['net']}, epoch {metrics['best_epoch']}",
        metrics["test/mse"],
        metrics["test/l1"],
    )
    log.info("  %-28s %.5f  %.4f", "ridge on the operators", ridge.mse, ridge.l1)
    log.info("  %-28s %.5f  %.4f", "mean of the training split", mean.mse, mean.l1)
    return metrics
