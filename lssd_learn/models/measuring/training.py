"""Makes a reader of body measures: a body that varies as known people do, and intervals that scans of others
calibrate."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import cast

import numpy as np
from jaxtyping import Float

from lssd_learn.cache import Cache, fingerprint
from lssd_learn.collections import Collection
from lssd_learn.collections.anthropometry.measures import NAMES
from lssd_learn.collections.parallel import in_parallel, on_one_thread
from lssd_learn.errors import InputError, check_whole
from lssd_learn.models.measuring.conformal import Widths
from lssd_learn.models.measuring.figure import Figure, People
from lssd_learn.models.measuring.laying import Layer
from lssd_learn.models.measuring.reader import BodyReader, faults, seen

VERSION = 3  # goes up whenever the same scan is read otherwise: it is part of the cache key
MODES = 64
STARTING = 6  # modes that the people differ in as whom it begins
CLASSES = 4  # of scans, by how doubtful they are, each with intervals of its own
# What is more than that of the worst scan of the calibration by this factor is refused, but not less than this: mm off,
# the parts that are missing and something else, and standard deviations from the mean: long hair and fists, which are
# none of the faults here, cost no measure.
BEYOND, ALLOWED = 1.5, np.array([12.0, 0.08, 0.12, 2.5])
# The same for signs of faults, of so large a part of the scans without: the body may lie wrong on one of them.
CLEAN, MOST = 1.2, 0.95
SIGNS = np.array([0.5, 0.01, 0.01, 1.3])


@dataclass(frozen=True)
class Made:
    """A reader, and what is known of its errors.

    Attributes:
        reader: the reader.
        truth, read: (s, p) of the scans it was calibrated on, in the units of the measures.
        kinds: (s,) the number of the collection that each is of.
    """

    reader: BodyReader
    truth: Float[np.ndarray, "s p"]
    read: Float[np.ndarray, "s p"]
    kinds: np.ndarray


def train_reader(
    people: People,
    turns: Float[np.ndarray, "s B 3 3"],
    loose: Float[np.ndarray, " B"],
    clean: Sequence[Collection],
    faulty: Sequence[Collection],
    level: float = 0.9,
    cache: Cache | None = None,
    key: str | None = None,
    workers: int | None = None,
    seed: int = 0,
) -> Made:
    """A reader of the `MEASURES`.

    Args:
        people: whom it learns from.
        turns: of joints in many poses, to begin with.
        loose: see `Layer`.
        clean, faulty: scans of other people, whose parameters are their measures, without and with faults.
        level: of the intervals.
        cache: where what is read of each scan is kept, under a key that holds all that the body comes from.
        workers: see `in_parallel`.
        seed: of the people as whom it begins.

    Raises:
        InputError: other parameters, too few scans for the intervals.
    """
    every = [*clean, *faulty]
    check_whole("task.scans", sum(map(len, every)), CLASSES * int(np.ceil(level / (1 - level))) + CLASSES)
    if any(list(some.parameter_names) != list(NAMES) for some in every):
        raise InputError("task.scans: expected scans whose parameters are the measures: collection=people")
    figure = on_one_thread(Figure.of, people, MODES)  # the same bits on any number of cores
    drawn = np.random.default_rng([seed, 7]).normal(size=(len(turns), min(STARTING, len(figure.rest_modes))))
    # What a file keeps in single precision is used so, that one that is read again reads the same.
    kept = (some.astype(np.float32).astype(float) for some in (loose, drawn, turns))
    layer = Layer(figure, *kept)
    kinds = np.repeat(np.arange(len(every)), [len(some) for some in every])
    numbers = np.concatenate([np.arange(len(some)) for some in every])
    found = list(in_parallel(_laid, range(len(kinds)), "laying", workers, layer, every, kinds, numbers, cache, key))
    read, told, marks = (np.stack(some) for some in zip(*found, strict=True))
    truth = np.concatenate([cast(np.ndarray, some.parameters) for some in every])
    known = [
        figure.meter.measure(rest, dict(zip(people.names, marks, strict=True)))
        for rest, marks in zip(people.rest, people.marks, strict=True)
    ]
    errors, without = np.log(read / truth), kinds < len(clean)
    reader = BodyReader(
        layer=layer,
        names=NAMES,
        mean=np.log(np.array(known)).mean(axis=0),
        widths=Widths.of(marks, errors, CLASSES, level),
        level=level,
        clean=np.maximum(CLEAN * np.quantile(told[without], MOST, axis=0), SIGNS),
        farthest=np.maximum(BEYOND * told.max(axis=0), ALLOWED),
    )
    return Made(reader, truth, read, kinds)


def _laid(
    i: int, layer: Layer, every: Sequence[Collection], kinds: np.ndarray, numbers: np.ndarray,
    cache: Cache | None, key: str | None,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:  # fmt: skip
    """What is read of scan i, its faults, and what is seen of it."""
    scans, number = every[kinds[i]], int(numbers[i])
    name = scans.shape_key(number)

    def made() -> dict[str, np.ndarray]:
        shape = scans[number]
        fit = layer.lay(shape)
        return {"read": layer.figure.measured(fit.pose.weights), "faults": faults(fit), "seen": seen(fit, shape)}

    if cache is None or key is None or name is None:
        found = made()
    else:
        found = cache.get("laid", fingerprint("laid", VERSION, key, name), made)
    return found["read"], found["faults"], found["seen"]
