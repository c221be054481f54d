"""The landmarks that shapes of a collection share, checked: where landmarks enter the computation of maps."""

import logging
from functools import cached_property

import numpy as np
from jaxtyping import Int

from lssd_learn.collections import Collection
from lssd_learn.errors import InputError, check_whole
from lssd_learn.shapes.sampling import farthest_points

log = logging.getLogger(__name__)

LEAST = 3
FLAT = 1e-3  # landmarks whose second extent is below this share of the first are on a line


class SharedLandmarks:
    """Which landmarks each two shapes of a collection share: one may be missing here, another there.

    Args:
        collection: n shapes.
        count: use so many of them, the farthest from one another, as the crow flies, on the first shape that has them
            all (or most); None is all.
        quiet: say nothing of those that some shapes lack.

    Raises:
        InputError: a shape without landmarks, a landmark that is no vertex, all of a shape on a line, count out of its
            range.
    """

    def __init__(self, collection: Collection, count: int | None = None, quiet: bool = False):
        names = collection.names
        placed = [dict(collection.landmarks[i]) if i < len(collection.landmarks) else {} for i in range(len(names))]
        for name, marks in zip(names, placed, strict=True):
            if not marks:
                raise InputError(f"maps: expected landmarks on every shape, {name} has none (see landmarks.csv)")
        self._names, self._placed = names, placed
        fullest = max(range(len(names)), key=lambda i: len(placed[i]))
        order = list(dict.fromkeys(mark for marks in [placed[0], placed[fullest], *placed] for mark in marks))
        if count is not None:
            most = [mark for mark in order if mark in placed[fullest]]
            check_whole("maps.landmarks", count, LEAST, len(most))
            vertices = np.array([placed[fullest][mark] for mark in most])
            _check(collection, fullest, vertices)
            chosen = set(np.sort(farthest_points(collection[fullest].vertices[vertices], count)).tolist())
            order = [mark for m, mark in enumerate(most) if m in chosen]
        self.order = order
        for i, marks in enumerate(placed):
            _check(collection, i, np.array([marks[mark] for mark in order if mark in marks], dtype=int))
        missing = sum(mark not in marks for mark in order for marks in placed)
        if missing and not quiet:
            log.info(
                "maps: %d of %d landmarks are on all shapes; each two shapes are mapped by those they share",
                len(self.common),
                len(order),
            )

    @cached_property
    def common(self) -> list[str]:
        """The names of those that all shapes have."""
        return [mark for mark in self.order if all(mark in marks for marks in self._placed)]

    def of_all(self) -> Int[np.ndarray, "n m"]:
        """(n, m) vertices of the m landmarks that all n shapes have.

        Raises:
            InputError: fewer than three.
        """
        if len(self.common) < LEAST:
            raise InputError(f"maps: expected {LEAST} landmarks or more that all shapes have, got {len(self.common)}")
        return np.array([[marks[mark] for mark in self.common] for marks in self._placed])

    def of_pair(self, i: int, j: int) -> tuple[Int[np.ndarray, " m"], Int[np.ndarray, " m"]]:
        """(m,) and (m,) vertices of the m landmarks that shapes i and j share.

        Raises:
            InputError: fewer than three.
        """
        a, b = self._placed[i], self._placed[j]
        shared = [mark for mark in self.order if mark in a and mark in b]
        if len(shared) < LEAST:
            raise InputError(
                f"maps: expected {LEAST} landmarks or more that {self._names[i]} and {self._names[j]} share, "
                f"got {len(shared)}"
            )
        return np.array([a[mark] for mark in shared]), np.array([b[mark] for mark in shared])


def common_landmarks(collection: Collection, count: int | None = None) -> Int[np.ndarray, "n m"]:
    """(n, m) vertices of the m landmarks that all n shapes have, in the order of the first shape.

    Args:
        collection, count: see `SharedLandmarks`.

    Raises:
        InputError: as there, or fewer than three in common.
    """
    return SharedLandmarks(collection, count).of_all()


def check_landmarks(
    collection: Collection, count: int | None = None, correspondence: str = "auto", **arguments
) -> None:
    """Whether a collection has the landmarks that maps of its shapes need, if they need any.

    Raises:
        InputError: as `SharedLandmarks`.
    """
    kinds = collection.connectivities
    if kinds is not None and (correspondence == "none" or len(set(kinds)) > 1 or kinds[0] is None):
        SharedLandmarks(collection, count, quiet=True)  # they are told when they are used


def _check(collection: Collection, i: int, vertices: np.ndarray) -> None:
    """Whether the landmarks of one shape are of use.

    Raises:
        InputError: too few, one is no vertex, or they are all on a line, which tells no side from another.
    """
    name, points = collection.names[i], collection[i].vertices
    if len(vertices) < LEAST:
        raise InputError(f"maps: expected {LEAST} landmarks or more on every shape, {name} has {len(vertices)}")
    wrong = (vertices < 0) | (vertices >= len(points))
    if wrong.any():
        raise InputError(
            f"maps: expected landmarks of {name} at vertices 0 to {len(points) - 1}, got {vertices[wrong][0]}"
        )
    marks = points[vertices]
    extents = np.linalg.svd(marks - marks.mean(axis=0), compute_uv=False)
    if extents[1] <= FLAT * extents[0]:
        raise InputError(f"maps: expected landmarks around the shape, the {len(marks)} of {name} are on a line")
