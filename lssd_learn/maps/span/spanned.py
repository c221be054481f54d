"""Third step: where each vertex of a new shape lies on the known ones, and theirs on it, by the mixture that fits."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from lssd_learn.collections.base import Collection
from lssd_learn.maps.matching.bending import closest
from lssd_learn.maps.matching.surface import near, on_faces
from lssd_learn.maps.span.fit import Surface, fitted
from lssd_learn.maps.span.span import nearest_to, span
from lssd_learn.shapes import Mesh
from lssd_learn.shapes.normals import normals

VERSION = 1  # goes up whenever the same shapes give other correspondences: it is part of the cache key
SHAPES, LEAST = 40, 10  # known shapes that are mixed, and fewer than which are not
SKETCH = 1000  # vertices by which they are chosen
OFF = 0.004  # root mean square distance from the surface, over √area, from which on a new shape is no mixture


@dataclass(frozen=True, eq=False)
class Spanned:
    """A new shape as a mixture of known ones, of V vertices each.

    Attributes:
        shapes: numbers of the known shapes, those that are most like it first.
        there: (V_new, 3) for each of its vertices the corners of a face of theirs.
        there_weights: (V_new, 3) its place among them.
        back, back_weights: (V, 3) the other way.
        off: root mean square distance between the mixture and its surface, over √area, the larger way.
    """

    shapes: Int[np.ndarray, " q"]
    there: Int[np.ndarray, "V_new 3"]
    there_weights: Float[np.ndarray, "V_new 3"]
    back: Int[np.ndarray, "V 3"]
    back_weights: Float[np.ndarray, "V 3"]
    off: Float[np.ndarray, ""]

    @property
    def fits(self) -> bool:
        """Whether it is one."""
        return bool(self.off <= OFF)


class Alike:
    """Shapes of a collection that share their faces, some vertices of each at hand.

    Args:
        collection: n shapes.
        numbers: of those that share them.
    """

    def __init__(self, collection: Collection, numbers: Sequence[int] | np.ndarray):
        self.collection, self.numbers = collection, np.asarray(numbers)
        self.count = len(collection[int(self.numbers[0])].vertices)
        self.some = np.unique(np.linspace(0, self.count - 1, min(SKETCH, self.count)).astype(int))
        self.sketches = np.stack([collection[int(k)].vertices[self.some] for k in self.numbers])


def spanned(
    alike: Alike, mass: Float[np.ndarray, " V"], places: Float[np.ndarray, "V 3"], mesh: Mesh, own: int = -1
) -> Spanned | None:
    """A new shape as a mixture of known ones; None where these are too few.

    Args:
        alike: the known shapes.
        mass: of their vertices.
        places: about where these lie on the new shape, by a map.
        mesh: the new shape.
        own: a known shape that is left out.
    """
    left = np.flatnonzero(alike.numbers != own)
    if len(left) < LEAST:
        return None
    size, some = np.sqrt(mesh.area), alike.some
    chosen = alike.numbers[left[nearest_to(alike.sketches[left], places[some], mass[some], SHAPES)]]
    shapes = [alike.collection[int(k)] for k in chosen]
    template = shapes[0]
    if not isinstance(template, Mesh):
        return None
    points, facing = mesh.vertices / size, normals(mesh)
    of = span(np.stack([shape.vertices for shape in shapes]) / size, places / size, mass)
    lying = fitted(of, template, places / size, Surface(points, facing))
    there, back = closest(lying, normals(template, lying), points, facing)
    faces, weights = on_faces(template.faces, lying, near(lying, points, there), points)
    others, shares = on_faces(mesh.faces, points, near(points, lying, back), lying)
    corners, ends = template.faces[faces], mesh.faces[others]
    off = max(_off(lying[corners], weights, points), _off(points[ends], shares, lying))
    return Spanned(chosen, corners, weights, ends, shares, np.array(off))


def _off(corners: np.ndarray, weights: np.ndarray, points: np.ndarray) -> float:
    """Root mean square distance of points (m, 3) from points in triangles."""
    away = np.einsum("mc,mcx->mx", weights, corners) - points
    return float(np.sqrt((away**2).sum(axis=1).mean()))
