"""New shapes in an old latent space, whatever they share with its shapes: nothing is fitted again.

Those with the faces of an old shape are pushed by vertex correspondence; of others maps to old shapes are computed.
"""

import logging
from collections.abc import Callable

from lssd_learn.collections.base import Collection
from lssd_learn.collections.eigenbases import eigenbases
from lssd_learn.errors import InputError
from lssd_learn.latent import LatentSpace
from lssd_learn.latent.newcomers import check_corresponds, push_all
from lssd_learn.latent.strangers import Arrived, push_strangers
from lssd_learn.pipeline import Pipeline

log = logging.getLogger(__name__)


def warn_of_frames(align: str) -> None:
    """Say that shapes a model was trained on were laid alike, and new ones are not laid on them.

    Args:
        align: of the collection that it was trained on.
    """
    if align != "none":
        log.warning(
            "the training shapes were laid alike (collection.align=%s); new shapes are not laid on them: give them as"
            " those lie, see aligned.csv of that run",
            align,
        )


def push_into(
    space: LatentSpace,
    known: Callable[[], Collection] | None,
    pipeline: Pipeline,
    laplacian: str = "auto",
    neighbours: int = 5,
    mapped: int = 1,
    candidates: int = 100,
) -> Arrived:
    """The shapes of a pipeline in the language of `space`, and what is known of the maps they came by.

    Args:
        space: with its eigenbases.
        known: makes the shapes of `space`, which maps are computed to; None where nobody knows them.
        pipeline: its collection, maps, cache and workers count. If all its shapes have faces that shapes of `space`
            have, maps are not asked for.
        laplacian: of the eigenbases of `space`.
        neighbours: see `push_all`.
        mapped, candidates: see `choose_neighbours`.

    Raises:
        InputError: a shape that has the faces of no old one, and maps that are not computed; `known` is None though
            they are.
    """
    collection, cache, workers, k = pipeline.collection, pipeline.cache, pipeline.workers, space.evals.shape[1]
    first = collection[0]
    if not pipeline.computes_maps:
        check_corresponds(space, collection.names[0], first.connectivity, len(first.vertices))  # before the long work
    log.info("eigenbases of %d functions, as in the latent space", k)
    bases = eigenbases(collection, k, laplacian, cache, workers)
    connectivities = {basis.connectivity for basis in space.bases or ()} - {None}
    if not pipeline.computes_maps or all(basis.connectivity in connectivities for basis in bases):
        return Arrived(push_all(space, bases, collection.names, neighbours))
    if known is None:
        raise InputError("ckpt_path: expected a checkpoint that says which shapes it was trained on; train it again")
    how = (mapped, candidates, cache, workers)
    old = known()
    old.keep_in(cache, workers)
    warn_of_frames(getattr(old, "align", "none"))
    return push_strangers(space, old, collection, bases, pipeline.maps, *how, pipeline.described_maps)
