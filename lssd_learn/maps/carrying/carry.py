"""Landmarks of a few shapes, the hubs, carried to others of a collection: from maps to places and error bars."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import cast

import numpy as np
from jaxtyping import Float

from lssd_learn.collections.base import Collection
from lssd_learn.collections.parallel import in_parallel
from lssd_learn.maps.carrying.consensus import Consensus, consensus
from lssd_learn.maps.carrying.doubts import Doubts, doubts, unrest
from lssd_learn.maps.carrying.patches import Laid, laid
from lssd_learn.maps.carrying.settled import PASSES, Patches, Surface, patches
from lssd_learn.maps.pairs import PairMaps
from lssd_learn.shapes import Mesh


@dataclass(frozen=True, eq=False)
class Hub:
    """A shape that has landmarks.

    Attributes:
        shape: its number in the collection.
        mesh: as it lies there.
        points: (L, 3) its landmarks, NaN where nobody knows.
        patches: around those that are known.
    """

    shape: int
    mesh: Mesh
    points: Float[np.ndarray, "L 3"]
    patches: Patches

    @property
    def here(self) -> np.ndarray:
        """(L,) bool: which are known."""
        return _here(self.points)


@dataclass(frozen=True, eq=False)
class Carried:
    """The landmarks of m shapes as the hubs say them.

    Attributes:
        shapes: their numbers in the collection.
        found: of each.
        bars: (m, L) root mean square errors to be expected, in the units of the shapes; NaN where nothing is known.
        doubts: what the hubs tell of errors; None of fewer than three.
        places: (m, H, L, 3) what each hub says, NaN where it says nothing or its map is not to be trusted.
        is_settled: whether patches were settled, see `settled.py`.
    """

    shapes: list[int]
    found: list[Consensus]
    bars: Float[np.ndarray, "m L"]
    doubts: Doubts | None
    places: Float[np.ndarray, "m H L 3"]
    is_settled: bool

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
        return np.isnan(given[self.shapes].sum(axis=2)) & np.isfinite(self.points.sum(axis=2))

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

    Patches settle where that brings the hubs' own landmarks nearer to where the others say them; of fewer than three
    hubs, which cannot tell, they do.

    Args:
        collection: meshes, in the units that the landmarks are in. The maps may be of these as they lie elsewhere.
        maps: of the collection, those of `pairs_of` prepared.
        hubs: numbers of H shapes.
        shapes: numbers of m shapes; those that are hubs hear of the others only.
        known: where the landmarks of the hubs lie; NaN where nobody knows.
        workers: see `in_parallel`.
    """
    every = list(dict.fromkeys([*hubs, *shapes]))
    meshes = [cast(Mesh, collection[h]) for h in hubs]
    own = [
        Hub(h, mesh, points, patches(points[_here(points)], mesh))
        for h, mesh, points in zip(hubs, meshes, known, strict=True)
    ]
    rows = in_parallel(_said, every, "landmarks", workers, collection, maps, own)
    said = dict(zip(every, rows, strict=True))
    both = {i: [consensus(places) for places in ways] for i, ways in said.items()}
    unrests = {i: unrest(*ways) for i, ways in both.items()}
    errors = [np.linalg.norm([both[h][way].points for h in hubs] - known, axis=2) for way in (0, 1)]
    told = [doubts(some, np.array([unrests[h] for h in hubs])) for some in errors]
    way = 1
    if told[0] is not None and told[1] is not None:
        way = int(np.nanmean(told[1].errors) <= np.nanmean(told[0].errors))
    of_shapes, chosen = np.array([unrests[i] for i in shapes]), told[way]
    bars = np.full_like(of_shapes, np.nan) if chosen is None else chosen.bars(of_shapes)
    places = np.array([said[i][way] for i in shapes])
    return Carried(list(shapes), [both[i][way] for i in shapes], bars, chosen, places, bool(way))


def _said(
    i: int, collection: Collection, maps: PairMaps, hubs: Sequence[Hub]
) -> tuple[Float[np.ndarray, "H L 3"], Float[np.ndarray, "H L 3"]]:
    """Where each hub says that the landmarks of shape i lie: by its map, and settled."""
    target = cast(Mesh, collection[i])
    lying: dict[int, Laid] = {}
    places = np.full((len(hubs), *hubs[0].points.shape), np.nan)
    for number, hub in enumerate(hubs):
        quality = None if hub.shape == i else maps.quality(hub.shape, i)
        if hub.shape != i and hub.here.any() and (quality is None or quality >= maps.level):
            how = maps.points(i, hub.shape)
            lying[number] = laid(hub.points[hub.here], hub.mesh, target, *how)
            places[number, hub.here] = lying[number].points
    settled, surface = places.copy(), Surface(target)
    for _ in range(PASSES):
        start = consensus(settled).points
        for number, how in lying.items():
            hub = hubs[number]
            settled[number, hub.here] = surface.settled(hub.patches, how, start[hub.here])
    return places, settled


def _here(points: Float[np.ndarray, "L 3"]) -> np.ndarray:
    """(L,) bool: which are known."""
    return np.isfinite(points.sum(axis=1))
