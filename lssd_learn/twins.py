"""`data.twins`: training that knows what computed maps do to operators.

A twin of a shape has a mesh of its own, or is a cloud, and is pushed into the latent space through computed maps to
other shapes than the one it was made of, as a new shape will be. Trained on shapes and twins, and chosen on twins
alone, a net learns what of an operator to trust.
"""

from dataclasses import dataclass

import numpy as np
import torch
from torch import Tensor

from lssd_learn import nets
from lssd_learn.collections import Remeshed, eigenbases
from lssd_learn.collections.chosen import Chosen
from lssd_learn.division.split import Split
from lssd_learn.errors import InputError, check_whole
from lssd_learn.latent.differences import stack_differences
from lssd_learn.latent.strangers import push_strangers
from lssd_learn.pieces import Pieces

TWINS = ("none", "mesh", "cloud")


@dataclass(frozen=True)
class Twinned:
    """Shapes and twins, one after the other.

    Attributes:
        operators: (n + m, channels, size, size).
        targets: (n + m, …).
        split: training on shapes and twins; validation and test on twins.
    """

    operators: Tensor
    targets: np.ndarray
    split: Split


def check_twins(pieces: Pieces, split: Split) -> None:
    """Refuse what `data.twins` cannot do, before the long work.

    Raises:
        InputError: no such twins, maps=correspondence, a latent space that is not fitted to all shapes, a net on
            clouds, too few twins for the three parts of the split.
    """
    pipeline, kind, count = pieces.pipeline, pieces.data.twins, pieces.data.twin_shapes
    if kind == TWINS[0]:
        return
    if kind not in TWINS:
        raise InputError(f"data.twins={kind}: expected one of {', '.join(TWINS)}")
    if not pipeline.computes_maps:
        raise InputError(f"data.twins={kind}: expected maps that are computed, such as maps=registration")
    if pipeline.fitted is not None:
        raise InputError(f"data.twins={kind}: expected data.protocol=transductive")
    if nets.reads(pieces.net) == "clouds":
        raise InputError(f"data.twins={kind}: expected a net on operators; net={pieces.choices['net']} reads clouds")
    check_whole("data.twin_shapes", count, 1)
    parts = positions(split, _chosen(pieces), len(pipeline.collection))
    if len(parts.train) == len(split.train) or not len(parts.test) or not len(parts.validation):
        raise InputError(f"data.twin_shapes={count}: expected twins in train, test and validation; take more")


def twinned(pieces: Pieces, targets, split: Split) -> Twinned:
    """What to train on where `data.twins` asks for it.

    Args:
        pieces: of the run. Its maps are those that new shapes will be mapped by.
        targets: (n, …) of the shapes.
        split: of the shapes; a twin is where its shape is.
    """
    pipeline, shapes, chosen = pieces.pipeline, pieces.pipeline.collection, _chosen(pieces)
    space, some = pipeline.latent, Chosen([(shapes, int(i)) for i in chosen])
    twins = Remeshed(some, pieces.data.twins, pieces.data.twin_vertices)
    bases = eigenbases(twins, space.evals.shape[1], pipeline.laplacian, pipeline.cache, pipeline.workers)
    pushed = push_strangers(
        space,
        shapes,
        twins,
        bases,
        pipeline.maps,
        neighbours=pieces.data.twin_neighbours,
        cache=pipeline.cache,
        workers=pipeline.workers,
        described=pipeline.described_maps,
        own=chosen.tolist(),
    ).space
    operators = torch.cat([pipeline.operators(pieces.operators), stack_differences(pushed, pieces.operators)])
    targets = np.asarray(targets)
    return Twinned(operators, np.concatenate([targets, targets[chosen]]), positions(split, chosen, len(shapes)))


def _chosen(pieces: Pieces) -> np.ndarray:
    """(m,) the shapes that have a twin: the first."""
    return np.arange(min(pieces.data.twin_shapes, len(pieces.pipeline.collection)))


def positions(split: Split, chosen: np.ndarray, n: int) -> Split:
    """The split of n shapes and, after them, the twins of some, chosen (m,): test and validation are twins alone."""
    twins = {name: n + np.flatnonzero(np.isin(chosen, some)) for name, some in split.items()}
    return Split(np.concatenate([split.train, twins["train"]]), twins["test"], twins["validation"])
