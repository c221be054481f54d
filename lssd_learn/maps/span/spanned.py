"""Third step: the mixture of known shapes that lies on a new one, and how far it is off."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

from lssd_learn.collections.base import Collection
from lssd_learn.kdtree import cKDTree
from lssd_learn.maps.matching.bending import closest
from lssd_learn.maps.matching.surface import near, on_faces
from lssd_learn.maps.span.bend import bent
from lssd_learn.maps.span.fit import Surface, fitted
from lssd_learn.maps.span.net import net
from lssd_learn.maps.span.span import Span, nearest_to, posed_off, span
from lssd_learn.shapes import Mesh, Shape
from lssd_learn.shapes.normals import normals

VERSION = 3  # goes up whenever the same shapes give another mixture: it is part of the cache key
SHAPES, LEAST = 40, 10  # known shapes that are mixed, and fewer than which are not
SKETCH = 1000  # vertices by which they are chosen
POSED = 8.0  # degrees, see `posed_off`, up to which shapes stand alike
OFF = 0.004  # root mean square distance from the surface, over √area, from which on a new shape is no mixture
CLEAR, GAIN = 0.0015, 0.5  # the same from which on bending is tried, and the share of it that has to be left
STRAIN = 0.25  # of a net from which on a new shape is not bent but another
APART = 0.02  # the same of a mixture from the points of a cloud


@dataclass(frozen=True, eq=False)
class Spanned:
    """A new shape as a mixture of known ones, of V vertices each.

    Attributes:
        shapes: numbers of the known shapes, those that are most like it first.
        points: (V, 3) of the mixture, in the units of the new shape. It lies as that does, unless it is bent.
        off: root mean square distance between the mixture, bent where it is, and the new surface, over √area, the
            larger way; of a cloud that of its points from the mixture.
        bent: whether it lies on the new shape only once it is bent.
    """

    shapes: Int[np.ndarray, " q"]
    points: Float[np.ndarray, "V 3"]
    off: Float[np.ndarray, ""]
    bent: Bool[np.ndarray, ""]

    @property
    def fits(self) -> bool:
        """Whether it is one."""
        return bool(self.off <= OFF)


class Alike:
    """Shapes of a collection that share their faces, some vertices of each at hand.

    Args:
        collection: n shapes.
        numbers: of those that share them, ascending.
    """

    def __init__(self, collection: Collection, numbers: Sequence[int] | np.ndarray):
        self.collection, self.numbers = collection, np.asarray(numbers)
        self.count = len(collection[int(self.numbers[0])].vertices)
        self.some = np.unique(np.linspace(0, self.count - 1, min(SKETCH, self.count)).astype(int))
        self.sketches = np.stack([collection[int(k)].vertices[self.some] for k in self.numbers])

    def nearest(self, among: np.ndarray, places: np.ndarray, mass: np.ndarray) -> Int[np.ndarray, " q"]:
        """Those of `among`, some of their numbers, that lie nearest to places (V, 3), the nearest first."""
        return among[nearest_to(self._of(among), places[self.some], mass[self.some], SHAPES)]

    def posed_as(self, among: np.ndarray, places: np.ndarray) -> Int[np.ndarray, " q"]:
        """Those of `among` that stand as the one does that stands most as places (V, 3) do, this one first."""
        sketches = self._of(among)
        off = posed_off(sketches, sketches[posed_off(sketches, places[self.some]).argmin()])
        order = np.argsort(off, kind="stable")[:SHAPES]
        return among[order[off[order] < POSED]]

    def _of(self, numbers: np.ndarray) -> np.ndarray:
        return self.sketches[np.searchsorted(self.numbers, numbers)]

    def span(self, chosen: np.ndarray, goals: Float[np.ndarray, "V 3"], mass: np.ndarray, size: float) -> Span:
        """What some of them span, laid on the goals, all over a size."""
        return span(np.stack([self.collection[int(k)].vertices for k in chosen]) / size, goals / size, mass)


def spanned(
    alike: Alike,
    mass: Float[np.ndarray, " V"],
    places: Float[np.ndarray, "V 3"],
    shape: Shape,
    own: int = -1,
    bend: bool = True,
) -> Spanned | None:
    """A new shape as a mixture of known ones; None where these are too few, or clouds.

    A new shape that is none may be one that is bent, as a person is who stands as no known one does: then it is that
    mixture, unbent, whose joints are those of the known shapes.

    Args:
        alike: the known shapes.
        mass: of their vertices.
        places: about where these lie on the new shape.
        shape: the new one.
        own: a known shape that is left out.
        bend: whether it may be bent.
    """
    left = alike.numbers[alike.numbers != own]
    template = alike.collection[int(alike.numbers[0])]
    if len(left) < LEAST or not isinstance(template, Mesh):
        return None
    size = np.sqrt(shape.area if isinstance(shape, Mesh) else Mesh(places, template.faces).area)
    onto = Surface(shape.vertices / size, normals(shape) if isinstance(shape, Mesh) else None)
    chosen = alike.nearest(left, places, mass)
    lying = fitted(alike.span(chosen, places, mass, size), template, places / size, onto)
    best = Spanned(chosen, lying * size, np.array(_apart(template, lying, shape, onto)), np.array(False))
    if not bend or best.off <= CLEAR:
        return best
    chosen = alike.posed_as(left, places)
    if len(chosen) < LEAST:
        return best  # of people in unlike poses a mixture is no person
    of = alike.span(chosen, alike.collection[int(chosen[0])].vertices, mass, size)
    straight, lying, strain = bent(of, template, net(Mesh(of.mean, template.faces)), places / size, onto)
    off = _apart(template, lying, shape, onto)
    if strain < STRAIN and off < GAIN * best.off:
        return Spanned(chosen, straight * size, np.array(off), np.array(True))
    return best


def _apart(template: Mesh, lying: np.ndarray, shape: Shape, onto: Surface) -> float:
    """`off` of `Spanned`, of a mixture at unit area."""
    points = onto.points
    if not isinstance(shape, Mesh) or onto.normals is None:
        there, away = cKDTree(lying).query(points)[1], cKDTree(points).query(lying)[0]
        # Points of a cloud are apart, and so is any from the mixture: what tells is whether all of it is near to some.
        off = 0.0 if np.sqrt((away**2).mean()) < APART else np.inf
    else:
        there, back = closest(lying, normals(template, lying), points, onto.normals)
        off = _off(shape.faces, points, near(points, lying, back), lying)
    return max(off, _off(template.faces, lying, near(lying, points, there), points))


def _off(faces: np.ndarray, points: np.ndarray, around: np.ndarray, wanted: np.ndarray) -> float:
    """Root mean square distance of wanted points (m, 3) from a mesh, looked for around some of its vertices (m, n)."""
    found, weights = on_faces(faces, points, around, wanted)
    away = np.einsum("mc,mcx->mx", weights, points[faces[found]]) - wanted
    return float(np.sqrt((away**2).sum(axis=1).mean()))
