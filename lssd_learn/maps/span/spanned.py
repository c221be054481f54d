"""Third step: the mixture of known shapes that lies on a new one, and how far it is off."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from lssd_learn.collections.base import Collection
from lssd_learn.kdtree import cKDTree
from lssd_learn.maps.matching.bending import closest
from lssd_learn.maps.matching.surface import near, on_faces
from lssd_learn.maps.span.fit import Surface, fitted
from lssd_learn.maps.span.span import nearest_to, span
from lssd_learn.shapes import Mesh, Shape
from lssd_learn.shapes.normals import normals

VERSION = 3  # goes up whenever the same shapes give another mixture: it is part of the cache key
SHAPES, LEAST = 40, 10  # known shapes that are mixed, and fewer than which are not
SKETCH = 1000  # vertices by which they are chosen
OFF = 0.004  # root mean square distance from the surface, over √area, from which on a new shape is no mixture
APART = 0.02  # the same of a mixture from the points of a cloud


@dataclass(frozen=True, eq=False)
class Spanned:
    """A new shape as a mixture of known ones, of V vertices each.

    Attributes:
        shapes: numbers of the known shapes, those that are most like it first.
        points: (V, 3) of the mixture, as the new shape lies and in its units.
        off: root mean square distance between the mixture and the new surface, over √area, the larger way; of a cloud
            that of its points from the mixture.
    """

    shapes: Int[np.ndarray, " q"]
    points: Float[np.ndarray, "V 3"]
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
    alike: Alike, mass: Float[np.ndarray, " V"], places: Float[np.ndarray, "V 3"], shape: Shape, own: int = -1
) -> Spanned | None:
    """A new shape as a mixture of known ones; None where these are too few, or clouds.

    Args:
        alike: the known shapes.
        mass: of their vertices.
        places: about where these lie on the new shape.
        shape: the new one.
        own: a known shape that is left out.
    """
    left = np.flatnonzero(alike.numbers != own)
    template, some = alike.collection[int(alike.numbers[0])], alike.some
    if len(left) < LEAST or not isinstance(template, Mesh):
        return None
    chosen = alike.numbers[left[nearest_to(alike.sketches[left], places[some], mass[some], SHAPES)]]
    size = np.sqrt(shape.area if isinstance(shape, Mesh) else Mesh(places, template.faces).area)
    points, facing = shape.vertices / size, normals(shape) if isinstance(shape, Mesh) else None
    of = span(np.stack([alike.collection[int(k)].vertices for k in chosen]) / size, places / size, mass)
    lying = fitted(of, template, places / size, Surface(points, facing))
    if not isinstance(shape, Mesh) or facing is None:
        there, away = cKDTree(lying).query(points)[1], cKDTree(points).query(lying)[0]
        # Points of a cloud are apart, and so is any from the mixture: what tells is whether all of it is near to some.
        off = 0.0 if np.sqrt((away**2).mean()) < APART else np.inf
    else:
        there, back = closest(lying, normals(template, lying), points, facing)
        off = _off(shape.faces, points, near(points, lying, back), lying)
    off = max(off, _off(template.faces, lying, near(lying, points, there), points))
    return Spanned(chosen, lying * size, np.array(off))


def _off(faces: np.ndarray, points: np.ndarray, around: np.ndarray, wanted: np.ndarray) -> float:
    """Root mean square distance of wanted points (m, 3) from a mesh, looked for around some of its vertices (m, n)."""
    found, weights = on_faces(faces, points, around, wanted)
    away = np.einsum("mc,mcx->mx", weights, points[faces[found]]) - wanted
    return float(np.sqrt((away**2).sum(axis=1).mean()))
