"""Landmarks of a few shapes, the hubs, carried to others of a collection: from maps to places and error bars."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from lssd_learn.collections.base import Collection
from lssd_learn.collections.parallel import in_parallel
from lssd_learn.maps.carrying.consensus import Consensus, consensus
from lssd_learn.maps.carrying.doubts import Doubts, doubts
from lssd_learn.maps.carrying.patches import carried
from lssd_learn.maps.pairs import PairMaps


@dataclass(frozen=True, eq=False)
class Carried:
    """The landmarks of m shapes as the hubs say them.

    Attributes:
        shapes: their numbers in the collection.
        found: of each.
        bars: (m, L) root mean square errors to be expected, in the units of the shapes; NaN where nothing is known.
        doubts: what the hubs tell of errors; None of fewer than three.
        places: (m, H, L, 3) what each hub says, NaN where it says nothing or its map is not to be trusted.
    """

    shapes: list[int]
    found: list[Consensus]
    bars: Float[np.ndarray, "m L"]
    doubts: Doubts | None
    places: Float[np.ndarray, "m H L 3"]

    @property
    def points(self) -> Float[np.ndarray, "m L 3"]:
        """NaN where no hub says anything."""
        return np.array([one.points for one in self.found])

    @property
    def lost(self) -> list[int]:
        """Numbers of the shapes of which no hub says anything."""
        return [i for i, one in zip(self.shapes, self.found, strict=True) if not one.count.any()]

    def new(self, given: Float[np.ndarray, "n L 3"]) -> np.ndarray:
        """(m, L) bool: whether a landmark is carried here, where it was not given (n shapes, NaN where it was not)."""
        return np.isnan(given[self.shapes]).any(axis=2) & np.isfinite(self.points).all(axis=2)

    def filled(self, given: Float[np.ndarray, "n L 3"]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """All of n shapes: places (n, L, 3), the given ones as they were, bars (n, L), and which are carried (n, L)."""
        points, bars, new = given.copy(), np.full(given.shape[:2], np.nan), np.zeros(given.shape[:2], dtype=bool)
        new[self.shapes] = self.new(given)
        for i, places, errors in zip(self.shapes, self.points, self.bars, strict=True):
            points[i, new[i]], bars[i, new[i]] = places[new[i]], errors[new[i]]
        return points, bars, new


def pairs_of(hubs: Sequence[int], shapes: Sequence[int]) -> list[tuple[int, int]]:
    """The maps that carrying needs: of every hub with the others, and with every shape."""
    wanted = {(min(h, i), max(h, i)) for h in hubs for i in [*hubs, *shapes] if i != h}
    return sorted(wanted)


def carry(
    collection: Collection,
    maps: PairMaps,
    hubs: Sequence[int],
    shapes: Sequence[int],
    known: Float[np.ndarray, "H L 3"],
    workers: int | None = None,
) -> Carried:
    """The landmarks of the hubs on other shapes; maps that are not to be trusted carry nothing.

    Args:
        collection: meshes, in the units that the landmarks are in. The maps may be of these as they lie elsewhere.
        maps: of the collection, those of `pairs_of` prepared.
        hubs: numbers of H shapes.
        shapes: numbers of m shapes; those that are hubs hear of the others only.
        known: where the landmarks of the hubs lie; NaN where nobody knows.
        workers: see `in_parallel`.
    """
    every = list(dict.fromkeys([*hubs, *shapes]))
    rows = in_parallel(_said, every, "landmarks", workers, collection, maps, list(hubs), known)
    places = dict(zip(every, rows, strict=True))
    told = doubts(np.array([places[h] for h in hubs]), known)
    found = [consensus(places[i]) for i in shapes]
    nothing = np.full(known.shape[1], np.nan)
    bars = [nothing if told is None else told.bars(one) for one in found]
    return Carried(list(shapes), found, np.array(bars), told, np.array([places[i] for i in shapes]))


def _said(
    i: int, collection: Collection, maps: PairMaps, hubs: Sequence[int], known: Float[np.ndarray, "H L 3"]
) -> Float[np.ndarray, "H L 3"]:
    """Where each hub says that the landmarks of shape i lie."""
    places = np.full(known.shape, np.nan)
    target = collection[i]
    for number, (h, points) in enumerate(zip(hubs, known, strict=True)):
        here = np.isfinite(points).all(axis=1)
        quality = None if h == i else maps.quality(h, i)
        if h != i and here.any() and (quality is None or quality >= maps.level):
            places[number, here] = carried(points[here], collection[h], target, *maps.points(i, h))
    return places
