"""How far points lie from a shape, and whether another frame or unit would bring them nearer: for `landmarks.py`."""

from dataclasses import dataclass
from functools import cached_property
from itertools import permutations, product
from typing import cast

import numpy as np
from trimesh.triangles import closest_point

from lssd_learn.kdtree import cKDTree
from lssd_learn.shapes import Mesh, Shape

NEAREST = 8  # vertices around which the nearest face is looked for
UNITS = (1000.0, 100.0, 10.0, 25.4, 2.54)  # of length to one another: mm, cm, m, inches
# A frame fits far better when the points are off by more than FAR of the shape's size as they stand, and it brings
# them to within a BETTER part of that; with few points less, so that one of all frames does so by chance in 1 of 1,000
# sets.
FAR, BETTER, CHANCE = 0.002, 0.25, 1e-3


class Surface:
    """A shape to which points can be near.

    Args:
        shape: a mesh, or a cloud, whose points are then all there is of it.
    """

    def __init__(self, shape: Shape):
        self.shape = shape
        low, high = shape.points.min(axis=0), shape.points.max(axis=0)
        self.low, self.high, self.size = low, high, float((high - low).max())

    @cached_property
    def tree(self) -> cKDTree:
        return cKDTree(self.shape.points)

    @cached_property
    def _faces_of(self) -> tuple[np.ndarray, np.ndarray]:
        """The faces, sorted by their corners, and where those of each vertex begin."""
        corners = cast(Mesh, self.shape).faces.ravel()  # asked of meshes only
        order = np.argsort(corners, kind="stable")
        begin = np.searchsorted(corners[order], np.arange(len(self.shape.points) + 1))
        return order // 3, begin

    def distances(self, points: np.ndarray) -> np.ndarray:
        """(m,) of points (m, 3) from the surface of a mesh, near the vertices nearest to them, or from a cloud."""
        distance, near = self.tree.query(points, k=min(NEAREST, len(self.shape.points)))
        if not isinstance(self.shape, Mesh):
            return distance.reshape(len(points), -1)[:, 0]
        near, (face, begin) = near.reshape(len(points), -1), self._faces_of
        nearest = distance.reshape(len(points), -1)[:, 0].copy()
        for j, vertices in enumerate(near):
            around = np.unique(np.concatenate([face[begin[v] : begin[v + 1]] for v in vertices]))
            if len(around):
                triangles = self.shape.vertices[self.shape.faces[around]]
                foot = closest_point(triangles, np.tile(points[j], (len(around), 1)))
                nearest[j] = min(nearest[j], np.linalg.norm(foot - points[j], axis=1).min())
        return nearest

    def to_vertices(self, points: np.ndarray) -> np.ndarray:
        """(m,) of points from the nearest vertex: quick, and up to half an edge too much."""
        return self.tree.query(points)[0]


@dataclass(frozen=True)
class Frame:
    """Axes and units in which points may have been written: (m, 3) points are those of a shape as `points @ matrix`."""

    matrix: np.ndarray
    name: str

    @property
    def is_turn(self) -> bool:
        """Whether lengths stay as they are."""
        return abs(abs(np.linalg.det(self.matrix)) - 1) < 1e-9


def frames() -> list[Frame]:
    """All ways to swap and turn round the axes, and the usual units."""
    found = []
    for order, signs in product(permutations(range(3)), product((1, -1), repeat=3)):
        matrix = np.zeros((3, 3))
        for axis, (source, sign) in enumerate(zip(order, signs, strict=True)):
            matrix[source, axis] = sign
        changed = (order, signs) != ((0, 1, 2), (1, 1, 1))
        if changed:
            found.append(Frame(matrix, _name(order, signs)))
    for factor in UNITS:
        found.append(Frame(np.eye(3) * factor, f"{factor:g} times as large"))
        found.append(Frame(np.eye(3) / factor, f"{factor:g} times as small"))
    return found


def _name(order: tuple[int, ...], signs: tuple[int, ...]) -> str:
    if order == (0, 1, 2):
        turned = [axis for axis, sign in zip("xyz", signs, strict=True) if sign < 0]
        text = f"{' and '.join(turned)} negated" if len(turned) < 3 else "x, y and z negated"
        return f"{text} (LPS for RAS, or the other way)" if signs == (-1, -1, 1) else text
    axes = ", ".join(f"{'-' if sign < 0 else ''}{'xyz'[source]}" for source, sign in zip(order, signs, strict=True))
    return f"({axes}) for (x, y, z)"


FRAMES = frames()


def better_frame(surface: Surface, points: np.ndarray, own: float) -> tuple[Frame, float] | None:
    """The frame that fits points (m, 3) to a surface far better than they do as they stand, and how far off they then
    are, the root mean square distance; None if there is none.

    Args:
        own: how far off they are as they stand.
    """
    if own <= FAR * surface.size or len(points) < 3:
        return None
    better = min(BETTER, (CHANCE / len(FRAMES)) ** (1 / len(points)))
    misfits = [np.sqrt(np.square(surface.to_vertices(points @ frame.matrix)).mean()) for frame in FRAMES]
    for best in np.argsort(misfits, kind="stable")[:3]:
        frame = FRAMES[best]
        misfit = np.sqrt(np.square(surface.distances(points @ frame.matrix)).mean())
        if misfit <= better * own:
            return frame, float(misfit)
    return None
