"""`task=predict`: the parameters of new shapes, or the group they are of, by a net trained before."""

import logging
from pathlib import Path
from typing import cast

import numpy as np
from scipy.special import softmax

from lssd_learn.collections import Collection
from lssd_learn.errors import InputError, some_of
from lssd_learn.learning import checkpoint
from lssd_learn.models import Trained
from lssd_learn.models.trained import read_trained
from lssd_learn.pieces import Pieces
from lssd_learn.pushing import warn_of_frames
from lssd_learn.unsaid import warn_of_seen
from lssd_learn.written import write_columns

log = logging.getLogger(__name__)

TABLE = "predictions.csv"


def run(pieces: Pieces, out: Path, neighbours: int, mapped: int = 1, candidates: int = 100) -> dict[str, float]:
    """Write predictions.csv: `name` and one column a parameter, as `labels.csv` of a folder has them; or `name`, the
    group and, for each class, its probability. Then how far to trust it: `size`, how many times larger than the
    training shapes in the middle the shape is; `unlike`, the share of training shapes that lie nearer to another than
    this shape lies to any: 1 is unlike anything seen; where maps were computed, `map_quality`, the median quality of
    those that the shape was read through, and `trusted_maps`, how many of them can be trusted; and `trusted`, 0 where
    any of these says that the row is not to be, which the log tells by name.

    The number of eigenfunctions, the Laplacian, the operators, the points of a cloud and the net are the checkpoint's,
    whatever the configuration says.

    Args:
        neighbours: training shapes each new one is pushed from, where it corresponds to them.
        mapped: where it does not and maps are computed; see `choose_neighbours` for these two.
        candidates: training shapes that these are chosen from.

    Returns:
        "shapes", how many there are, and "trusted", how many predictions can be; where the collection says what the
        parameters or the groups are, "test/mse" and "test/l1", or "test/accuracy", too.

    Raises:
        InputError: no checkpoint or an unfit one, a shape that does not correspond to the training shapes though
            maps=correspondence, eigenbases of theirs that are missing in the cache.
    """
    if pieces.ckpt_path is None:
        raise InputError("task=predict: expected ckpt_path=…, the best.ckpt of a task=regression or =classification")
    collection = pieces.pipeline.collection
    trained = read_trained(pieces.ckpt_path, pieces.net, pieces.pipeline.cache, ["regression", "classification"])
    known = checkpoint.read(pieces.ckpt_path)
    if "by" in known:
        warn_of_seen(collection, known["by"], known["seen"])
    warn_of_frames(known.get("align", "none"))
    seen = trained.look(pieces.pipeline, neighbours, mapped, candidates)
    predictions = trained.outputs(seen.inputs)
    tell = _tell_groups if trained.classes else _tell_parameters
    columns, metrics = tell(trained, predictions, collection)
    write_columns({"name": collection.names} | columns | seen.doubts, out / TABLE)
    if seen.doubtful.any():
        lost = [name for name, doubtful in zip(collection.names, seen.doubtful, strict=True) if doubtful]
        log.warning("%d of %d predictions are not to be trusted: %s", len(lost), len(collection), some_of(lost))
    what = trained.group if trained.classes else f"{len(trained.parameters)} parameters"
    log.info("%s of %d shapes: %s", what, len(collection), out / TABLE)
    return {"shapes": len(collection), "trusted": int((~seen.doubtful).sum())} | metrics


def _tell_parameters(
    trained: Trained, predictions: np.ndarray, collection: Collection
) -> tuple[dict[str, list], dict[str, float]]:
    """The columns of the table, and the errors as far as the collection knows better."""
    columns, metrics = dict(zip(trained.parameters, predictions.T.tolist(), strict=True)), {}
    known = list(collection.parameter_names)
    absent = [name for name in trained.parameters if name not in known]
    if not absent:
        truth = cast(np.ndarray, collection.parameters)[:, [known.index(name) for name in trained.parameters]]
        metrics["test/mse"] = float(np.mean((predictions - truth) ** 2))
        metrics["test/l1"] = float(np.mean(np.abs(predictions - truth)))
        log.info("error (MSE, L1) on %d shapes: %.4g  %.4g", len(collection), metrics["test/mse"], metrics["test/l1"])
    elif known:
        log.info("the collection does not say what %s is, so nothing is compared", ", ".join(absent))
    return columns, metrics


def _tell_groups(
    trained: Trained, predictions: np.ndarray, collection: Collection
) -> tuple[dict[str, list], dict[str, float]]:
    """The same of a classification, from the numbers that softmax makes probabilities of."""
    chosen = [trained.classes[i] for i in predictions.argmax(1)]
    columns = {trained.group: chosen}
    for label, chances in zip(trained.classes, softmax(predictions, axis=1).T.tolist(), strict=True):
        columns[f"{trained.group}={label}"] = chances
    if trained.group not in collection.groups:
        return columns, {}
    right = float(np.mean([str(a) == str(b) for a, b in zip(collection.groups[trained.group], chosen, strict=True)]))
    log.info("%s is right of %.2f %% of %d shapes", trained.group, 100 * right, len(collection))
    return columns, {"test/accuracy": right}
