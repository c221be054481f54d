"""Many shapes: what every collection offers, and the wrapper that makes a collection of a plain list."""

from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from lssd_learn.cache import Cache
from lssd_learn.shapes import Shape


class Collection(Sequence[Shape]):
    """A sequence of shapes with what is known about them. Shapes are made or read when asked for, one at a time.

    Subclasses give `__len__` and `__getitem__` (an int) and set what they know:

    Attributes:
        names: one a shape, unique.
        parameters: (n, p) float64, what a regression learns; None without.
        parameter_names: p names.
        groups: name → (n,) array of labels.
        landmarks: a mapping (landmark name → vertex) a shape.
        vertex_maps: (a, b) → for each vertex of b the vertex of a.
        parts: name → (V,) bool vertex mask, of a collection with one connectivity.
        key: what the cache knows this collection by: a hash of all that determines its shapes; None if unknown, and
            then nothing computed from it is cached.
        up: the axis that points up, "z" or "y", for display only; None if unknown.
    """

    names: Sequence[str]
    parameters: np.ndarray | None = None
    parameter_names: Sequence[str] = ()
    groups: Mapping[str, np.ndarray] = {}
    landmarks: Sequence[Mapping[str, int]] = ()
    vertex_maps: Mapping[tuple[int, int], np.ndarray] = {}
    parts: Mapping[str, np.ndarray] = {}
    key: str | None = None
    up: str | None = None

    def check(self) -> None:
        """Look at every shape, here and now: errors and repairs are told before any long work starts.

        Raises:
            InputError: a shape, or what is said about it, cannot be used. A generated collection has nothing to check.
        """

    def keep_in(self, cache: Cache | None, workers: int | None = None) -> None:
        """Keep what is computed of all shapes together in `cache`, from now on, by so many processes.

        Of most collections nothing is: their shapes have nothing to do with one another.
        """

    def shape_key(self, i: int) -> str | None:
        """The cache's name of shape i: changes whenever the shape does. None if `key` is."""
        return None if self.key is None else f"{self.key}/{i}"


class ShapeList(Collection):
    """A plain list of shapes as a collection: names are their positions, nothing else is known."""

    def __init__(self, shapes: Iterable[Shape]):
        self._shapes = list(shapes)
        self.names = [str(i) for i in range(len(self._shapes))]

    def __len__(self) -> int:
        return len(self._shapes)

    def __getitem__(self, i: int) -> Shape:
        return self._shapes[i]


def as_collection(shapes: Sequence[Shape]) -> Collection:
    """`shapes` itself if it is a collection, otherwise wrapped as one."""
    return shapes if isinstance(shapes, Collection) else ShapeList(shapes)
