"""`task=predict`: the parameters of new shapes, or the group they are of, by a net trained before.

Operators of new shapes have to speak the language the net has learnt: they are pushed into the latent space that its
checkpoint carries, from training shapes they are in vertex correspondence with, or that maps are computed to. Nothing
is fitted again.
"""

import logging
from pathlib import Path

import numpy as np
import torch
from scipy.special import softmax
from torch import Tensor

from lssd_learn.collections import Collection
from lssd_learn.collections.eigenbases import eigenbases
from lssd_learn.errors import InputError
from lssd_learn.latent import LatentSpace
from lssd_learn.latent.newcomers import check_corresponds, corresponds, push_all
from lssd_learn.latent.strangers import push_strangers
from lssd_learn.maps import VertexMaps
from lssd_learn.pipeline import Pipeline, stack_differences
from lssd_learn.tasks.pieces import Pieces
from lssd_learn.tasks.rows import write_columns
from lssd_learn.tasks.trained import Trained, read_trained

log = logging.getLogger(__name__)

TABLE = "predictions.csv"


def run(pieces: Pieces, out: Path, neighbours: int, mapped: int = 1, candidates: int = 100) -> dict[str, float]:
    """Write predictions.csv: `name` and one column a parameter, as `labels.csv` of a folder has them; or `name`, the
    group and, for each class, its probability.

    The number of eigenfunctions, the Laplacian, the operators, the points of a cloud and the net are the checkpoint's,
    whatever the configuration says.

    Args:
        neighbours: training shapes each new one is pushed from, where it corresponds to them.
        mapped: where it does not and maps are computed; see `choose_neighbours` for these two.
        candidates: training shapes that these are chosen from.

    Returns:
        "shapes"; where the collection says what the parameters or the groups are, "test/mse" and "test/l1", or
        "test/accuracy", too.

    Raises:
        InputError: no checkpoint or an unfit one, a shape that does not correspond to the training shapes though
            maps=correspondence, eigenbases of theirs that are missing in the cache.
    """
    if pieces.ckpt_path is None:
        raise InputError("task=predict: expected ckpt_path=…, the best.ckpt of a task=regression or =classification")
    collection = pieces.pipeline.collection
    trained = read_trained(pieces.ckpt_path, pieces.net, pieces.pipeline.cache, ["regression", "classification"])
    predictions = predict(trained, make_inputs(trained, pieces.pipeline, neighbours, mapped, candidates))
    tell = _tell_groups if trained.classes else _tell_parameters
    columns, metrics = tell(trained, predictions, collection)
    write_columns({"name": collection.names} | columns, out / TABLE)
    what = f"{trained.group}" if trained.classes else f"{len(trained.parameters)} parameters"
    log.info("%s of %d shapes: %s", what, len(collection), out / TABLE)
    return {"shapes": len(collection)} | metrics


def _tell_parameters(
    trained: Trained, predictions: np.ndarray, collection: Collection
) -> tuple[dict[str, list], dict[str, float]]:
    """The columns of the table, and the errors as far as the collection knows better."""
    columns, metrics = dict(zip(trained.parameters, predictions.T.tolist(), strict=True)), {}
    known = list(collection.parameter_names)
    absent = [name for name in trained.parameters if name not in known]
    if not absent:
        truth = collection.parameters[:, [known.index(name) for name in trained.parameters]]
        metrics["test/mse"] = float(np.mean((predictions - truth) ** 2))
        metrics["test/l1"] = float(np.mean(np.abs(predictions - truth)))
        log.info("error (MSE, L1) on %d shapes: %.5f  %.4f", len(collection), metrics["test/mse"], metrics["test/l1"])
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
    right = float(np.mean([str(a) == b for a, b in zip(collection.groups[trained.group], chosen, strict=True)]))
    log.info("%s is right of %.2f %% of %d shapes", trained.group, 100 * right, len(collection))
    return columns, {"test/accuracy": right}


def make_inputs(
    trained: Trained, pipeline: Pipeline, neighbours: int = 5, mapped: int = 1, candidates: int = 100
) -> Tensor:
    """What the net is to read of the collection of `pipeline`: operators (n, channels, m, m) or clouds (n, points, 3).

    Args:
        trained: says which.
        pipeline: its collection, maps, cache and workers count. Shapes are pushed by vertex correspondence if its maps
            are that or the first shape has the faces of a training shape, else by computed maps.
        neighbours: see `push_all`.
        mapped, candidates: see `choose_neighbours`.
    """
    if trained.latent is None:
        return torch.tensor(pipeline.clouds(trained.points))
    return stack_differences(push(trained, pipeline, neighbours, mapped, candidates), trained.operators)


def push(
    trained: Trained, pipeline: Pipeline, neighbours: int = 5, mapped: int = 1, candidates: int = 100
) -> LatentSpace:
    """The shapes of `pipeline` in the latent space of `trained`, as `make_inputs` wants them."""
    collection, space, cache, workers = pipeline.collection, trained.latent, pipeline.cache, pipeline.workers
    first, k = collection[0], space.evals.shape[1]
    computes = getattr(pipeline.maps, "func", pipeline.maps) is not VertexMaps
    computes = computes and not corresponds(space, first.connectivity)
    if not computes:
        check_corresponds(space, collection.names[0], first.connectivity, len(first.vertices))  # before the long work
    elif trained.collection is None:
        raise InputError("ckpt_path: expected a checkpoint that says which shapes it was trained on; train it again")
    log.info("eigenbases of %d functions, as in the checkpoint", k)
    bases = eigenbases(collection, k, trained.laplacian, cache, workers)
    if not computes:
        return push_all(space, bases, collection.names, neighbours)
    how, known = (mapped, candidates, cache, workers), trained.collection()
    known.keep_in(cache, workers)
    return push_strangers(space, known, collection, bases, pipeline.maps, *how, pipeline.described_maps)


@torch.no_grad()
def predict(trained: Trained, inputs: Tensor, batch: int = 50) -> np.ndarray:
    """(n, p) float64, in the order of `trained.parameters` or of `trained.classes`."""
    learner = trained.learner
    predictions = torch.cat([learner(some.to(learner.mean)) for some in inputs.split(batch)])
    return predictions.double().numpy()
