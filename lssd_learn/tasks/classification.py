"""`task=classification`: tell which group every shape is of, from its operators or its points."""

import logging
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from lssd_learn.collections.groups import choose_group, encode
from lssd_learn.errors import InputError
from lssd_learn.learning import Classification, linear_reference, majority_reference, operator_features
from lssd_learn.pieces import Pieces
from lssd_learn.tasks.training import plan, train

log = logging.getLogger(__name__)


def run(
    pieces: Pieces, out: Path, epochs: int, group: str | None = None, milestones: Sequence[int] = ()
) -> dict[str, float]:
    """Train a net on the labels of one group; say beside it what closed-form references reach on the split.

    best.ckpt holds `group`, its name, and `classes`, the label of each output of the net.

    Args:
        epochs: passes over the training split.
        group: one of the collection's; None is the only one there is.
        milestones: epochs up to which the best is scored too.

    Returns:
        test/accuracy, the metrics of `lssd_learn.learning.fit` and reference/{majority,linear}/accuracy.
    """
    group = choose_group(pieces.pipeline.collection, group, "task.group")
    classes, labels = encode(pieces.pipeline.collection.groups[group])
    if len(classes) < 2:
        raise InputError(f"task.group={group}: expected 2 classes or more, every shape is {classes[0]!r}")
    parts, epochs = plan(pieces, epochs, Classification)
    unseen = [repr(classes[c]) for c in np.setdiff1d(labels, labels[parts.train])]
    if unseen:
        log.warning("%s: the training split has no shape of %s, so no net can learn it", group, ", ".join(unseen))
    majority = majority_reference(labels, parts)
    linear = linear_reference(operator_features(pieces.pipeline.operators(pieces.operators)), labels, parts)

    metrics = train(
        pieces,
        out,
        labels,
        parts,
        epochs,
        milestones=milestones,
        module=Classification,
        carries={"group": group, "classes": classes},
    )
    net = f"{pieces.choices['net']}, epoch {metrics['best_epoch']}"
    log.info("%s, %d classes: right of %d test shapes", group, len(classes), len(parts.test))
    log.info("  %-28s %.2f %%", net, 100 * metrics["test/accuracy"])
    log.info("  %-28s %.2f %%", "linear on the operators", 100 * linear.accuracy)
    log.info("  %-28s %.2f %%", "most frequent in training", 100 * majority.accuracy)
    return {
        "test/accuracy": metrics["test/accuracy"],  # first: the summary of a sweep draws what comes first
        **metrics,
        "reference/majority/accuracy": majority.accuracy,
        "reference/linear/accuracy": linear.accuracy,
    }
