"""Makes a reader of body measures: a ridge on many bodies in correspondence and some as scans come, which has seen what
computed maps do to operators. Other scans calibrate its intervals.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import cast

import numpy as np
import torch
from jaxtyping import Bool, Float

from lssd_learn.collections import Collection
from lssd_learn.errors import InputError, check_whole
from lssd_learn.latent.differences import stack_differences
from lssd_learn.learning.references.ridge import ALPHAS, Ridge
from lssd_learn.models.measuring.conformal import conformal_width
from lssd_learn.models.measuring.features import Features
from lssd_learn.models.measuring.reader import BodyReader
from lssd_learn.models.unlike import unlike
from lssd_learn.pipeline import Pipeline
from lssd_learn.shapes import Mesh

# Beyond the farthest scan of the training by this factor one is refused.
BEYOND = 1.15
# A scan counts as so many bodies in correspondence.
COUNTS = 3
# The strength of the ridge is chosen on each of so many parts of the scans by what the others say.
FOLDS = 6


@dataclass(frozen=True)
class Made:
    """A reader, and what is known of its errors.

    Attributes:
        reader: the reader.
        truth, read: (c, p) of the scans it was calibrated on, in the units of the measures.
        trusted: (s,) whether the map of each scan can be trusted.
    """

    reader: BodyReader
    truth: Float[np.ndarray, "c p"]
    read: Float[np.ndarray, "c p"]
    trusted: Bool[np.ndarray, " s"]


def train_reader(
    pipeline: Pipeline, scans: Collection, operators: Sequence[str], references: int, taught: int, level: float = 0.9
) -> Made:
    """A reader of the parameters of a collection, which have to be above zero.

    Args:
        pipeline: of bodies in correspondence, in metres.
        scans: bodies of other people as scans come, with the same parameters.
        operators: which differences are read.
        references: so many bodies, the first, are what scans are mapped to.
        taught: so many scans, the first, are learnt from too; the others calibrate the intervals.
        level: of the intervals.

    Raises:
        InputError: numbers out of their range, other parameters, bodies that are not in correspondence.
    """
    bodies = pipeline.collection
    check_whole("task.references", references, 1, len(bodies))
    check_whole("task.taught", taught, FOLDS, len(scans) - 1)
    if bodies.parameters is None or not (bodies.parameters > 0).all():
        raise InputError("task=reader: expected bodies with measures above zero: collection=people")
    if list(scans.parameter_names) != list(bodies.parameter_names):
        raise InputError("task.scans: expected the parameters of the collection")
    shapes = [bodies[i] for i in range(references)]
    if not all(isinstance(shape, Mesh) and shape.connectivity == shapes[0].connectivity for shape in shapes):
        raise InputError("task=reader: expected meshes of the same faces")
    seen, space = pipeline.operators(operators), pipeline.latent.some(range(references))
    features, targets = Features.of(seen, pipeline.latent.evals), np.log(bodies.parameters)
    known = features(seen, pipeline.latent.evals)
    reader = BodyReader(
        space=space,
        vertices=np.stack([shape.points for shape in shapes]),
        faces=cast(Mesh, shapes[0]).faces,
        operators=tuple(operators),
        features=features,
        centre=known.mean(0),
        weights=np.zeros((known.shape[1], targets.shape[1])),
        mean=targets.mean(0),
        widths=np.zeros(targets.shape[1]),
        names=tuple(bodies.parameter_names),
        level=level,
    )
    came, evals, quality, trust = reader.push(scans, pipeline.cache)
    trusted, first = quality >= trust, np.arange(len(scans)) < taught
    teach, calibrate = np.flatnonzero(trusted & first), np.flatnonzero(trusted & ~first)
    if len(teach) < FOLDS or not len(calibrate):
        raise InputError("task.scans: expected maps that can be trusted, both to learn from and to calibrate with")
    read, truth = features(came, evals), np.log(cast(np.ndarray, scans.parameters))
    weights = _fit(known, targets, read[teach], truth[teach])
    reader = replace(reader, centre=read[teach].mean(0), mean=truth[teach].mean(0), weights=weights)
    predicted = reader.predict(read[calibrate])
    widths = conformal_width(np.log(predicted) - truth[calibrate], level)
    beyond = unlike(came[torch.from_numpy(trusted)], stack_differences(space, operators))[1]
    reader = replace(reader, widths=widths, farthest=float(BEYOND * beyond.max()))
    return Made(reader, np.exp(truth[calibrate]), predicted, trusted)


def _fit(
    known: Float[np.ndarray, "n d"],
    targets: Float[np.ndarray, "n p"],
    scans: Float[np.ndarray, "m d"],
    wanted: Float[np.ndarray, "m p"],
) -> Float[np.ndarray, "d p"]:
    """(d, p) weights of a ridge, of each target of the strength that is best on scans it was not fitted to.

    Bodies and scans are each taken about their own means: what maps do to all scans alike is nothing to learn from.
    """
    fold, errors = np.arange(len(scans)) % FOLDS, np.zeros((len(ALPHAS), targets.shape[1]))
    for part in range(FOLDS):
        out, rest = scans[fold == part], scans[fold != part]
        ridge = _ridge(known, targets, rest, wanted[fold != part], out - rest.mean(0))
        some = np.arange(len(ridge.projected) - len(out), len(ridge.projected))
        aim = wanted[fold == part] - wanted[fold != part].mean(0)
        errors += [np.square(ridge.at(some, alpha) - aim).sum(0) for alpha in ALPHAS]
    ridge = _ridge(known, targets, scans, wanted, scans[:0])
    best, squares = np.array(ALPHAS)[errors.argmin(0)], ridge.singular[:, None] ** 2
    shrunk = ridge.singular[:, None] / (squares + best * squares.mean())
    return cast(np.ndarray, ridge.axes).T @ (shrunk * ridge.loads)


def _ridge(known, targets, scans, wanted, others) -> Ridge:
    """Fitted to bodies and, `COUNTS` times, scans; `others` are behind them."""
    features = [known - known.mean(0), *[scans - scans.mean(0)] * COUNTS]
    aims = [targets - targets.mean(0), *[wanted - wanted.mean(0)] * COUNTS, np.zeros((len(others), targets.shape[1]))]
    train = np.arange(sum(map(len, features)))
    return Ridge.fit(np.concatenate([*features, others]), np.concatenate(aims), train)
