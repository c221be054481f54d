"""`maps=auto`: shapes matched as they lie, pair by pair, with the quality of each map kept beside it."""

import logging
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property, lru_cache
from numbers import Real
from typing import cast

import numpy as np

from lssd_learn.errors import InputError, some_of
from lssd_learn.maps.computed import ComputedMaps
from lssd_learn.maps.correspondence import from_points
from lssd_learn.maps.kernel_matching import KernelMatching, matched_vertices
from lssd_learn.maps.match import Found, matched, on_source, on_target, ready
from lssd_learn.maps.matching.prepared import Prepared
from lssd_learn.maps.pairs import VertexMaps
from lssd_learn.maps.quality import unreached
from lssd_learn.shapes import Mesh, PointCloud

log = logging.getLogger(__name__)

REMEMBERED = 8  # shapes a process keeps prepared, ten megabytes each
NEAR, STEPS = 0.04, 1.2  # from a point that a map leads to, over √area, or so many spaces between vertices: reached


@dataclass(frozen=True)
class Auto:
    """What `maps=auto` may choose.

    Attributes:
        trusted: quality, 0 to 1, below which a map is warned of.

    Raises:
        InputError: out of this range.
    """

    trusted: float = 0.5

    def __post_init__(self):
        if isinstance(self.trusted, bool) or not isinstance(self.trusted, Real) or not 0 <= self.trusted <= 1:
            raise InputError(f"maps.trusted={self.trusted}: expected a number from 0 to 1")


class AutoMaps(ComputedMaps):
    """`maps=auto`: nothing but the shapes is needed, in any pose and however they are turned; see `match.match`.

    Maps that somebody gives, as in the maps/ files of a folder, are taken instead; the truth about generated shapes is
    not. Pairs with a cloud, which has no triangles to tell left from right, are left to `kernel_matching`: these shapes
    stand upright and face one way.

    Args:
        bases, collection, correspondence: see `ComputedMaps`.
        choices: see `Auto`.
    """

    Choices = Auto
    version = 7
    how: Auto

    @property
    def level(self) -> float:
        """The quality that is trusted."""
        return self.how.trusted

    @property
    def turned(self) -> bool:
        """Clouds too: only where no mixture of known shapes fits, see `maps.span`, is a cloud to stand upright."""
        return True

    @cached_property
    def _given(self) -> VertexMaps | None:
        taken = len(self._collection.vertex_maps) and not (self._ignored or self._collection.truth)
        return VertexMaps(self._bases, self._collection) if taken else None

    def _known(self, i: int, j: int) -> bool:
        """Whether nothing has to be computed to carry functions from shape i to shape j."""
        return self._correspond(i, j) or (self._given is not None and self._given.given(i, j) is not None)

    def _both_known(self, i: int, j: int) -> bool:
        """The same, either way."""
        return self._known(i, j) and self._known(j, i)

    def vertex_maps(self, i: int, j: int) -> tuple[np.ndarray, np.ndarray]:
        entry = self.pair(i, j)
        return entry["there"], entry["back"]

    def _pair(self, i: int, j: int) -> dict[str, np.ndarray]:
        """The vertex maps "there" and "back"; of two meshes also the points inside triangles and the quality."""
        if any(isinstance(self._collection[k], PointCloud) for k in (i, j)):
            there, back = matched_vertices(*self._both(i, j), KernelMatching())
            return {"there": there, "back": back}
        source, target = (_ready(_Request(self, k)) for k in (i, j))
        return _entry(source, target, matched(source, target))

    def quality(self, i: int, j: int) -> float | None:
        """In [0, 1], see `matching.measures.chosen`; None where no map is computed or it is of a cloud."""
        if self._both_known(i, j):
            return None
        found = self._stored.entry(self, min(i, j), max(i, j)).get("quality")
        return None if found is None else float(found)

    def points(self, i: int, j: int) -> tuple[np.ndarray, np.ndarray]:
        if self._given is not None and self._known(i, j):
            return self._given.points(i, j)
        entry = {} if self._correspond(i, j) else self._stored.entry(self, min(i, j), max(i, j))
        way = "there" if i < j else "back"
        if f"{way}_weights" not in entry:
            return super().points(i, j)
        return entry[f"{way}_corners"], entry[f"{way}_weights"]

    def unreached(self, i: int, j: int) -> tuple[float, float] | None:
        """See `PairMaps`; known of maps that are computed between meshes."""
        if self._both_known(i, j):
            return None
        found = self._stored.entry(self, min(i, j), max(i, j)).get("unreached")
        return None if found is None else tuple(found.tolist() if i < j else found[::-1].tolist())

    def __call__(self, i: int, j: int) -> np.ndarray:
        if self._given is not None and self._known(i, j):
            return self._given(i, j)
        entry = {} if self._correspond(i, j) else self._stored.entry(self, min(i, j), max(i, j))
        way = "there" if i < j else "back"
        if f"{way}_weights" not in entry:
            return super().__call__(i, j)
        return from_points(self._bases[i], self._bases[j], entry[f"{way}_corners"], entry[f"{way}_weights"])

    def prepare(self, pairs: Iterable[tuple[int, int]], workers: int | None = None) -> None:
        pairs = sorted({(min(i, j), max(i, j)) for i, j in pairs if not self._both_known(i, j)})
        super().prepare(pairs, workers)
        if any(isinstance(self._collection[k], PointCloud) for pair in pairs for k in pair):
            log.warning(
                "maps=auto: clouds have no triangles to tell left from right; they are taken to stand upright and to "
                "face one way, and nothing is known of the quality of their maps"
            )
        known = [(self.quality(i, j), i, j) for i, j in pairs]
        bad = sorted(found for found in known if found[0] is not None and found[0] < self.how.trusted)
        if bad:
            names = self._collection.names
            named = some_of([f"{names[i]} and {names[j]} ({q:.2f})" for q, i, j in bad])
            log.warning(
                "maps: %d of %d maps are not to be trusted (quality below %g): %s",
                len(bad), len(known), self.how.trusted, named,
            )  # fmt: skip


class _Request:
    """Shape i of a collection of maps."""

    def __init__(self, maps: AutoMaps, i: int):
        self.maps, self.i = maps, i

    def __hash__(self) -> int:
        return hash((id(self.maps), self.i))

    def __eq__(self, other) -> bool:
        return self.maps is other.maps and self.i == other.i

    def made(self) -> Prepared:
        return ready(cast(Mesh, self.maps._collection[self.i]), self.maps._bases[self.i])


@lru_cache(REMEMBERED)
def _ready(request: _Request) -> Prepared:
    return request.made()


def _entry(source: Prepared, target: Prepared, found: Found) -> dict[str, np.ndarray]:
    entry = {"quality": np.array(found.quality)}
    radius = max(NEAR, STEPS / np.sqrt(min(len(source.points), len(target.points))))
    for way, points_of in (("there", on_source), ("back", on_target)):
        corners, weights = points_of(source, target, found)
        entry[way] = corners[np.arange(len(corners)), weights.argmax(axis=1)]
        entry[f"{way}_corners"], entry[f"{way}_weights"] = corners.astype(np.int32), weights.astype(np.float32)
    sides = (source, entry["there"]), (target, entry["back"])
    entry["unreached"] = np.array([unreached(side.points, side.basis.mass, to, radius) for side, to in sides])
    return entry
