"""The landmarks that all shapes of a collection have, checked: where landmarks enter the computation of maps."""

import logging

import numpy as np

from lssd_learn.collections import Collection
from lssd_learn.errors import InputError, check_whole
from lssd_learn.shapes.sampling import farthest_points

log = logging.getLogger(__name__)

LEAST = 3
FLAT = 1e-3  # landmarks whose second extent is below this share of the first are on a line


def common_landmarks(collection: Collection, count: int | None = None) -> np.ndarray:
    """(n, m) vertices of the m landmarks that all n shapes have, in the order of the first shape.

    Args:
        collection: n shapes.
        count: use so many of them, the farthest from one another on the first shape, as the crow flies; None is all.

    Raises:
        InputError: a shape without landmarks, fewer than three in common, a landmark that is no vertex, all of a shape
            on a line, count out of range.
    """
    names = collection.names
    placed = [dict(collection.landmarks[i]) if i < len(collection.landmarks) else {} for i in range(len(names))]
    for name, marks in zip(names, placed, strict=True):
        if not marks:
            raise InputError(f"maps: expected landmarks on every shape, {name} has none (see landmarks.csv)")
    common = [mark for mark in placed[0] if all(mark in marks for marks in placed)]
    if len(common) < LEAST:
        raise InputError(f"maps: expected {LEAST} landmarks or more that all shapes have, got {len(common)}")
    most = max(map(len, placed))
    if len(common) < most:
        log.info("maps: %d of %d landmarks are on all shapes", len(common), most)
    vertices = np.array([[marks[mark] for mark in common] for marks in placed])
    if count is not None:
        check_whole("maps.landmarks", count, LEAST, len(common))
        _check(collection, 0, vertices[0])
        chosen = np.sort(farthest_points(collection[0].vertices[vertices[0]], count))
        vertices = vertices[:, chosen]
    for i in range(len(names)):
        _check(collection, i, vertices[i])
    return vertices


def _check(collection: Collection, i: int, vertices: np.ndarray) -> None:
    """Whether the landmarks of one shape are of use.

    Raises:
        InputError: one is no vertex, or they are all on a line, which tells no side from another.
    """
    points = collection[i].vertices
    wrong = (vertices < 0) | (vertices >= len(points))
    if wrong.any():
        raise InputError(
            f"maps: expected landmarks of {collection.names[i]} at vertices 0 to {len(points) - 1}, "
            f"got {vertices[wrong][0]}"
        )
    marks = points[vertices]
    extents = np.linalg.svd(marks - marks.mean(axis=0), compute_uv=False)
    if extents[1] <= FLAT * extents[0]:
        raise InputError(
            f"maps: expected landmarks around the shape, the {len(marks)} of {collection.names[i]} are on a line"
        )
