"""Which shapes of a collection have landmarks, which lack them, and from whom they are carried."""

import logging
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from lssd_learn.collections.aligned import Aligned
from lssd_learn.collections.base import Collection
from lssd_learn.collections.folder import Folder
from lssd_learn.errors import InputError, some_of
from lssd_learn.latent.graphs.medoids import medoids
from lssd_learn.maps.carrying.carry import Carried
from lssd_learn.shapes import Eigenbasis, Mesh

log = logging.getLogger(__name__)

FUNCTIONS = 50  # frequencies that shapes are told apart by


@dataclass(frozen=True, eq=False)
class Asked:
    """The landmarks of n shapes, as they are given.

    Attributes:
        collection: the shapes as they lie in their files: landmarks are read and written there.
        labels: names of the L landmarks that any shape has.
        points: (n, L, 3) in the units of the shapes, NaN for those that are not there.
    """

    collection: Collection
    labels: list[str]
    points: Float[np.ndarray, "n L 3"]

    @property
    def counts(self) -> np.ndarray:
        """(n,) landmarks that each shape has."""
        return np.isfinite(self.points.sum(axis=2)).sum(axis=1)

    @property
    def lacking(self) -> list[int]:
        """Numbers of the shapes that lack any."""
        return np.flatnonzero(self.counts < len(self.labels)).tolist()


def landmarks_of(collection: Collection) -> Asked:
    """The landmarks of a collection, looked at.

    Raises:
        InputError: no shape has any, one is no mesh, or shapes are of another size than in their files.
    """
    if isinstance(collection, Aligned):
        collection = collection.collection
    if isinstance(collection, Folder) and collection.normalise_area:
        raise InputError(
            "landmarks: expected collection.normalise_area=false, since landmarks are in units of the files"
        )
    marks = [collection.marked(i) for i in range(len(collection))]
    labels = list(dict.fromkeys(mark for own in marks for mark in own))
    if not labels:
        raise InputError("landmarks: expected some of the shapes to have landmarks (see landmarks.csv), got none")
    cloud = next((i for i, shape in enumerate(collection) if not isinstance(shape, Mesh)), None)
    if cloud is not None:
        raise InputError(f"landmarks: expected meshes, {collection.names[cloud]} is a cloud")
    nowhere = np.full(3, np.nan)
    points = np.array([[own.get(label, nowhere) for label in labels] for own in marks], dtype=float)
    return Asked(collection, labels, points)


def asked(collection: Collection) -> Asked:
    """`landmarks_of` a collection in which some shapes lack some.

    Raises:
        InputError: as there, or no shape lacks any.
    """
    given = landmarks_of(collection)
    if not given.lacking:
        n, count = len(given.points), len(given.labels)
        raise InputError(f"landmarks: all {n} shapes have all {count} landmarks; there is nothing to carry")
    return given


def named_hubs(given: Asked, hubs: Sequence[str]) -> list[int]:
    """Numbers of the shapes of these names.

    Raises:
        InputError: a name that no shape has, or of one without landmarks.
    """
    number = {name: i for i, name in enumerate(given.collection.names)}
    for name in map(str, hubs):
        if name not in number:
            raise InputError(f"task.hubs: expected names of shapes, got {name!r}")
        if not given.counts[number[name]]:
            raise InputError(f"task.hubs: expected shapes that have landmarks, {name} has none")
    return [number[name] for name in dict.fromkeys(map(str, hubs))]


def choose_hubs(bases: Sequence[Eigenbasis], given: Asked, most: int) -> list[int]:
    """Of the shapes that have the most landmarks so many that lie in the midst of the others.

    They are medoids of the frequencies √λ at unit area (Shape-DNA): where the landmarks lie has no part in it.
    """
    able = np.flatnonzero(given.counts == given.counts.max()).tolist()
    if len(able) <= most:
        return able
    some = [bases[i] for i in able]
    frequencies = np.array([np.sqrt(np.maximum(basis.evals[1:FUNCTIONS], 0) * basis.area) for basis in some])
    return sorted(able[number] for number in medoids(frequencies, most))


def metrics_of(given: Asked, found: Carried, hubs: Sequence[int]) -> dict[str, float]:
    """Counts, and of three hubs or more how far their own are off where the others say them, and the mean bar."""
    new = found.new(given.points)
    counts: dict[str, float] = {"shapes": len(found.shapes) - len(found.lost), "landmarks": int(new.sum())}
    counts |= {"left_out": len(found.lost), "hubs": len(hubs)}
    if found.doubts is None:
        return counts
    return counts | {
        "hub_error": float(np.nanmean(found.doubts.errors)),
        "error_bar": float(np.nanmean(found.bars[new])),
    }


def slips_of(given: Asked, found: Carried, hubs: Sequence[int]) -> list[str]:
    """Of the hubs' own landmarks those that are far from where the others say them, the farthest first, in words."""
    slips = [] if found.doubts is None else found.doubts.slips
    return [f"{given.labels[mark]} of {given.collection.names[hubs[h]]}" for h, mark in slips]


def tell(given: Asked, found: Carried, hubs: Sequence[int]) -> None:
    """Say in the log what was carried, from whom, and who was left out."""
    names = given.collection.names
    if found.lost:
        log.warning(
            "landmarks: %d of %d shapes have no map to be trusted from any of the hubs and get none: %s",
            len(found.lost), len(found.shapes), some_of([names[i] for i in found.lost]),
        )  # fmt: skip
    if found.doubts is None:
        log.warning("landmarks: %d shapes with landmarks tell nothing of errors; three or more do", len(hubs))
    slips = slips_of(given, found, hubs)
    if slips:
        log.warning(
            "landmarks: %d given ones are far from where the others say them; look whether they are right: %s",
            len(slips), some_of(slips),
        )  # fmt: skip
    log.info(
        "%d landmarks carried to %d shapes from %d: %s",
        found.new(given.points).sum(), len(found.shapes) - len(found.lost), len(hubs),
        some_of([names[h] for h in hubs], 10),
    )  # fmt: skip
