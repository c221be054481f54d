"""What a trained model reads of new shapes, and what it says of them.

Operators of new shapes have to speak the language the net has learnt: they are pushed into the latent space that its
checkpoint carries, from training shapes they are in vertex correspondence with, or that maps are computed to. Nothing
is fitted again.
"""

import logging

import numpy as np
import torch
from torch import Tensor

from lssd_learn.collections.eigenbases import eigenbases
from lssd_learn.errors import InputError
from lssd_learn.latent import LatentSpace
from lssd_learn.latent.newcomers import check_corresponds, corresponds, push_all
from lssd_learn.latent.strangers import push_strangers
from lssd_learn.models.trained import Trained
from lssd_learn.pipeline import Pipeline, stack_differences

log = logging.getLogger(__name__)


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
    computes = pipeline.computes_maps and not corresponds(space, first.connectivity)
    if not computes:
        check_corresponds(space, collection.names[0], first.connectivity, len(first.vertices))  # before the long work
    elif trained.collection is None:
        raise InputError("ckpt_path: expected a checkpoint that says which shapes it was trained on; train it again")
    log.info("eigenbases of %d functions, as in the checkpoint", k)
    bases = eigenbases(collection, k, trained.laplacian, cache, workers)
    if not computes:
        return push_all(space, bases, collection.names, neighbours)
    how, known = (mapped, candidates, cache, workers), trained.collection()
    return push_strangers(space, known, collection, bases, pipeline.maps, *how, pipeline.described_maps)


@torch.no_grad()
def predict(trained: Trained, inputs: Tensor, batch: int = 50) -> np.ndarray:
    """(n, p) float64, in the order of `trained.parameters` or of `trained.classes`."""
    learner = trained.learner
    predictions = torch.cat([learner(some.to(learner.mean)) for some in inputs.split(batch)])
    return predictions.double().numpy()
