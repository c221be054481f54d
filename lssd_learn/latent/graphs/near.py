"""Which points lie nearest, exactly, in memory that grows with their number: what the topologies of `topology.py` need.

Distances of all pairs are never held. A k-d tree finds candidates, in coordinates turned so that those along which the
points spread come first: spectra of shapes spread along few. What the candidates' order is comes from their distances
in the coordinates as they were given, so that ties are the ties of the distances.
"""

from collections.abc import Iterator

import numpy as np
from jaxtyping import Float, Int
from scipy.spatial.distance import cdist

from lssd_learn.kdtree import cKDTree

ENTRIES = 1 << 22  # of the largest array of distances that is held at once
ROUNDING = 1e-12  # of turned coordinates, relative to their size
SPARE = 4  # candidates beyond those asked for, so that a few ties need no second search


def nearest(
    points: Float[np.ndarray, "n d"], others: Float[np.ndarray, "m d"], count: int, own: bool = False
) -> tuple[Int[np.ndarray, "n count"], Float[np.ndarray, "n count"]]:
    """The `count` of `others` (m, d) that are nearest to each of `points` (n, d): their numbers (n, count) and their
    distances, nearest first, of equal ones that with the lower number first.

    Args:
        own: `others` are the points themselves, and none is its own neighbour.
    """
    points, others = np.asarray(points, dtype=float), np.asarray(others, dtype=float)
    space = Turned(others)
    numbers, lengths = np.empty((len(points), count), dtype=np.int64), np.empty((len(points), count))
    candidates, left = count + own + SPARE, np.arange(len(points))
    if candidates < len(others) // 2:
        turned, open_rows = space(points), []
        search = Search(space.points)
        for rows in blocks(by_place(turned), candidates):
            found, near = search.query(turned[rows], candidates)
            for row, far, some in zip(rows, found[:, -1], near, strict=True):
                some = np.sort(some[some != row]) if own else np.sort(some)
                away = cdist(points[row : row + 1], others[some])[0]
                order = np.argsort(away, kind="stable")[:count]
                numbers[row], lengths[row] = some[order], away[order]
                if far <= lengths[row, -1] + space.rounding:  # one beyond the candidates may be as near
                    open_rows.append(row)
        left = np.sort(np.array(open_rows, dtype=np.int64))
    for rows in blocks(left, len(others)):
        away = cdist(points[rows], others)
        if own:
            away[np.arange(len(rows)), rows] = np.inf
        numbers[rows] = np.argsort(away, axis=1, kind="stable")[:, :count]
        lengths[rows] = np.take_along_axis(away, numbers[rows], axis=1)
    return numbers, lengths


def blocks(rows: Int[np.ndarray, " n"], width: int) -> Iterator[np.ndarray]:
    """The rows, some at a time: so many that an array of them of this width holds no more than `ENTRIES`."""
    step = max(1, ENTRIES // max(1, width))
    return (rows[begin : begin + step] for begin in range(0, len(rows), step))


def by_place(points: Float[np.ndarray, "n d"]) -> Int[np.ndarray, " n"]:
    """The numbers of points, those side by side that lie near each other: asked for in this order they find what they
    need in the processor's memory, which a long search waits for otherwise."""
    return cKDTree(points).indices


class Search:
    """A k-d tree of points that lie in memory as they lie in space."""

    def __init__(self, points: Float[np.ndarray, "m d"]):
        self._order = by_place(points)
        self._tree = cKDTree(points[self._order])

    def query(
        self, points: Float[np.ndarray, "n d"], count: int = 1
    ) -> tuple[Float[np.ndarray, "n ..."], Int[np.ndarray, "n ..."]]:
        """Distances and numbers of the nearest, as `cKDTree.query` gives them."""
        away, found = self._tree.query(points, count)
        return away, self._order[found]


class Turned:
    """Coordinates along the principal axes of some points, the widest first.

    Attributes:
        points: the points in these coordinates.
        rounding: by how much a distance may differ from that of the points as they were given.
    """

    def __init__(self, points: Float[np.ndarray, "m d"]):
        self._mean = points.mean(axis=0)
        centred = points - self._mean
        self._axes = np.linalg.eigh(centred.T @ centred)[1][:, ::-1]
        self.points = centred @ self._axes
        self.rounding = ROUNDING * float(np.abs(self.points).max(initial=0) + np.abs(self._mean).max(initial=0))

    def __call__(self, points: Float[np.ndarray, "n d"]) -> Float[np.ndarray, "n d"]:
        return (points - self._mean) @ self._axes
