"""Makes a reader of body measures: a ridge on scans, and on many bodies in correspondence whose vertices slide as they
do on scans. Other scans calibrate its intervals.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import cast

import numpy as np
from jaxtyping import Bool, Float

from lssd_learn.cache import Cache
from lssd_learn.collections import Collection
from lssd_learn.errors import InputError, check_whole
from lssd_learn.models.measuring.conformal import conformal_width
from lssd_learn.models.measuring.features import Chords
from lssd_learn.models.measuring.landing import References
from lssd_learn.models.measuring.reader import BodyReader
from lssd_learn.models.measuring.tapes import Loop
from lssd_learn.shapes import Mesh

CHORDS = 4000
SPAN = 60  # principal components of bodies; what is off them is like none
# Beyond the farthest scan of the training by this factor one is refused.
BEYOND = 1.15
# Every body is learnt from with the errors of so many maps, and a scan counts as so many of these.
COPIES, COUNTS = 6, 3
# The strength of the ridge, of the sum of squares, is chosen on each of so many parts of the scans.
FOLDS = 4
STRENGTHS = 10.0 ** np.arange(-7, -2.4, 0.5)


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


@dataclass(frozen=True)
class Examples:
    """What is learnt from: n bodies and m scans, all as d features and p logarithms of measures.

    Attributes:
        known, targets: (n, d), (n, p) of the bodies.
        came: (m, d) of the scans, and true: what they would be if maps made no error.
        wanted: (m, p) of the scans.
    """

    known: Float[np.ndarray, "n d"]
    targets: Float[np.ndarray, "n p"]
    came: Float[np.ndarray, "m d"]
    true: Float[np.ndarray, "m d"]
    wanted: Float[np.ndarray, "m p"]

    def less(self, out: Bool[np.ndarray, " m"]) -> "Examples":
        """Without some of the scans."""
        return replace(self, came=self.came[~out], true=self.true[~out], wanted=self.wanted[~out])


def train_reader(
    bodies: Collection,
    scans: Collection,
    twins: Collection,
    references: int,
    taught: int,
    level: float = 0.9,
    cache: Cache | None = None,
    workers: int | None = None,
    loops: Mapping[str, Loop] | None = None,
) -> Made:
    """A reader of the parameters of a collection, which have to be above zero.

    Args:
        bodies: in correspondence, in metres.
        scans: bodies of other people as scans come, with the same parameters.
        twins: the bodies of the scans, in correspondence with `bodies`.
        references: so many bodies, the first, are what scans are mapped to.
        taught: so many scans, the first, are learnt from too; the others calibrate the intervals.
        level: of the intervals.
        cache, workers: see `References.land`.
        loops: name of each girth → where its tape lies on the bodies, for pictures.

    Raises:
        InputError: numbers out of their range, other parameters, bodies that are not in correspondence.
    """
    check_whole("task.references", references, 1, len(bodies))
    check_whole("task.taught", taught, FOLDS, len(scans) - 1)
    if bodies.parameters is None or not (bodies.parameters > 0).all():
        raise InputError("task=reader: expected bodies with measures above zero: collection=people")
    if list(scans.parameter_names) != list(bodies.parameter_names):
        raise InputError("task.scans: expected the parameters of the collection")
    kinds = {shape.connectivity if isinstance(shape, Mesh) else None for some in (bodies, twins) for shape in some}
    if len(kinds) > 1 or None in kinds:
        raise InputError("task=reader: expected meshes of the same faces")
    vertices, faces = np.stack([shape.points for shape in bodies]), cast(Mesh, bodies[0]).faces
    chords, mapped_to = Chords.of(vertices, faces, CHORDS), References(vertices[:references], faces)
    landed = mapped_to.land(scans, cache, workers)
    trusted, first = landed.quality >= landed.level, np.arange(len(scans)) < taught
    teach, calibrate = np.flatnonzero(trusted & first), np.flatnonzero(trusted & ~first)
    if len(teach) < FOLDS or not len(calibrate):
        raise InputError("task.scans: expected maps that can be trusted, both to learn from and to calibrate with")
    known, came, truth = chords(vertices), chords(landed.points), np.log(cast(np.ndarray, scans.parameters))
    true = chords(np.stack([shape.points for shape in twins]))
    centre, mean, weights = _fit(Examples(known, np.log(bodies.parameters), came[teach], true[teach], truth[teach]))
    reader = BodyReader(
        references=mapped_to,
        chords=chords,
        centre=centre,
        span=_components(known),
        weights=weights,
        mean=mean,
        widths=np.zeros(truth.shape[1]),
        names=tuple(bodies.parameter_names),
        level=level,
        loops=loops or {},
    )
    predicted = reader.predict(came[calibrate])
    widths = conformal_width(np.log(predicted) - truth[calibrate], level)
    reader = replace(reader, widths=widths, farthest=float(BEYOND * reader.unlike(came[trusted]).max()))
    return Made(reader, np.exp(truth[calibrate]), predicted, trusted)


def _components(known: Float[np.ndarray, "n d"]) -> Float[np.ndarray, "r d"]:
    """(r, d) the first principal components, a quarter of as many as there are bodies at most."""
    return np.linalg.svd(known - known.mean(0), full_matrices=False)[2][: min(SPAN, len(known) // 4)]


def _fit(examples: Examples) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Of features (d,) what is taken off, what is then added to (p,), and weights (d, p): each target with the strength
    that is best on scans it was not fitted to."""
    fold = np.arange(len(examples.came)) % FOLDS
    errors = np.zeros((len(STRENGTHS), examples.targets.shape[1]))
    for part in range(FOLDS):
        out = fold == part
        ridge = _Ridge.of(examples.less(out))
        for place, strength in enumerate(STRENGTHS):
            read = ridge.mean + (examples.came[out] - ridge.centre) @ ridge.weights(np.array(strength))
            errors[place] += np.square(read - examples.wanted[out]).sum(0)
    ridge = _Ridge.of(examples)
    return ridge.centre, ridge.mean, ridge.weights(STRENGTHS[errors.argmin(0)])


@dataclass(frozen=True)
class _Ridge:
    """Ridge regression for any strength.

    Attributes:
        centre: (d,) of features as maps leave them, mean (p,) of targets.
        axes: (d, r) of the features, variances (r,) along them, loads (r, p) of the targets.
    """

    centre: np.ndarray
    mean: np.ndarray
    axes: np.ndarray
    variances: np.ndarray
    loads: np.ndarray

    @classmethod
    def of(cls, examples: Examples, seed: int = 0) -> "_Ridge":
        """Bodies get the errors of maps of scans that are drawn at random, less their mean and of either sign."""
        rng, n = np.random.default_rng(seed), len(examples.known)
        errors = examples.came - examples.true
        bias = errors.mean(0)
        rows, aims = [examples.came - bias] * COUNTS, [examples.wanted] * COUNTS
        for _ in range(COPIES):
            drawn, signs = rng.integers(len(errors), size=n), rng.choice([-1.0, 1.0], size=(n, 1))
            rows, aims = [*rows, examples.known + signs * (errors - bias)[drawn]], [*aims, examples.targets]
        features, targets = np.concatenate(rows), np.concatenate(aims)
        centre, mean = features.mean(0), targets.mean(0)
        features, targets = features - centre, targets - mean
        few = len(features) < features.shape[1]
        squares, vectors = np.linalg.eigh(features @ features.T if few else features.T @ features)
        kept = squares > 1e-9 * squares[-1]
        squares, vectors = squares[kept], vectors[:, kept]
        axes = features.T @ (vectors / np.sqrt(squares)) if few else vectors
        return cls(centre + bias, mean, axes, squares, axes.T @ (features.T @ targets))

    def weights(self, strength: np.ndarray) -> np.ndarray:
        """(d, p), a strength for all targets or (p,) one for each, of the sum of squares."""
        return self.axes @ (self.loads / (self.variances[:, None] + strength * self.variances.sum()))
