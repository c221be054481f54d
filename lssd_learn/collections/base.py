"""Many shapes: what every collection offers, and a plain list of them as one."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, ClassVar, overload

import numpy as np

from lssd_learn.cache import Cache
from lssd_learn.collections.picking import Picking, Some
from lssd_learn.shapes import Shape


class Collection(Picking[Shape]):
    """A sequence of shapes with what is known about them. Shapes are made or read when asked for, one at a time.

    `collection[2:5]`, `collection[[4, 0]]` and `collection[mask]` are collections of some of the shapes, each once.

    Subclasses give `__len__` and `__getitem__` (of an int from 0, all else is seen to) and set what they know:

    Attributes:
        names: one a shape, unique.
        parameters: (n, p) float64, what a regression learns; None without.
        parameter_names: p names.
        groups: name → (n,) array of labels.
        covariates: name → (n,) float64, numbers that are nobody's target, nan where unknown.
        landmarks: a mapping (landmark name → vertex) a shape.
        vertex_maps: (a, b) → for each vertex of b the vertex of a.
        truth: whether these are the truth about generated shapes, which a method that it is to judge must not see.
        parts: name → (V,) bool vertex mask, of a collection with one connectivity.
        key: what the cache knows this collection by: a hash of all that determines its shapes; None if unknown, and
            then nothing computed from it is cached.
        up: the axis that points up, "z" or "y", for display only; None if unknown.
    """

    names: Sequence[str]
    parameters: np.ndarray | None = None
    parameter_names: Sequence[str] = ()
    groups: Mapping[str, np.ndarray] = {}
    covariates: Mapping[str, np.ndarray] = {}
    landmarks: Sequence[Mapping[str, int]] = ()
    vertex_maps: Mapping[tuple[int, int], np.ndarray] = {}
    truth: bool = False
    parts: Mapping[str, np.ndarray] = {}
    key: str | None = None
    up: str | None = None
    part: ClassVar[Callable[["Collection", list[int]], "Collection"]]  # see `subset.Subset`

    if TYPE_CHECKING:  # what becomes of the subclasses' own, see `picking.py`

        @overload
        def __getitem__(self, index: int) -> Shape: ...
        @overload
        def __getitem__(self, index: Some) -> "Collection": ...
        def __getitem__(self, index: int | Some) -> "Shape | Collection": ...

    def _some(self, positions: list[int]) -> "Collection":
        return Collection.part(self, positions)

    @property
    def iloc(self) -> "Collection":
        """With `take` what scikit-learn cuts folds by: parameters, landmarks and maps of the shapes go with them."""
        return self

    def take(self, positions: Some, axis: int = 0) -> "Collection":
        """`collection[positions]`."""
        return self[positions]

    def __repr__(self) -> str:
        names = list(self.names)
        some = ", ".join(names) if len(names) < 4 else f"{names[0]}, {names[1]}, …, {names[-1]}"
        return f"{type(self).__name__}({len(names):,} shape{'s'[: len(names) != 1]}{': '[: 2 * bool(names)]}{some})"

    def check(self) -> Sequence[str]:
        """Look at every shape, here and now: errors and repairs are told before any long work starts.

        Returns:
            The warnings, said already, that runs should hear which find everything computed.

        Raises:
            InputError: a shape, or what is said about it, cannot be used. A generated collection has nothing to check.
        """
        return ()

    @property
    def connectivities(self) -> Sequence[str | None] | None:
        """The `connectivity` of each shape, where it is known without making them anew; None where it is not."""
        return None

    def remind(self, warnings: Iterable[str]) -> None:
        """Say warnings of an earlier `check`, but for those that were said already."""

    def told(self) -> Sequence[str]:
        """What `check` has said of the shapes: what was mended, left out or guessed. Of generated ones nothing."""
        return ()

    def changes(self) -> Sequence[Mapping[str, object]]:
        """What was done to each shape before anything was computed from it, a row a shape; none where nothing was."""
        return ()

    def marked(self, i: int) -> Mapping[str, np.ndarray]:
        """Landmark name → (3,) where it lies beside shape i, on the surface or off it, in the units of the shape."""
        marks = self.landmarks[i] if len(self.landmarks) else {}
        vertices = self[i].vertices if marks else np.empty((0, 3))
        return {name: vertices[vertex] for name, vertex in marks.items()}

    def lacks(self, what: str, name: str | None = None) -> str:
        """Why the collection has no `groups` or no `parameters`, or none of a name, for the message of a task."""
        return "this collection has none (see labels.csv)"

    def keep_in(self, cache: Cache | None, workers: int | None = None) -> None:
        """Keep what is computed of all shapes together in `cache`, from now on, by so many processes.

        Of most collections nothing is: their shapes have nothing to do with one another.
        """

    def shape_key(self, i: int) -> str | None:
        """The cache's name of shape i: changes whenever the shape does. None if `key` is."""
        return None if self.key is None else f"{self.key}/{i}"

    def space(self, i: int) -> str:
        """The coordinate system of shape i, "LPS" or "RAS", where its file or its landmarks say it; ""."""
        return ""


class ShapeList(Collection):
    """A plain list of shapes as a collection: names are their positions, nothing else is known."""

    def __init__(self, shapes: Iterable[Shape]):
        self._shapes: list[Any] = list(shapes)  # files too, where a subclass reads them
        self.names = [str(i) for i in range(len(self._shapes))]

    def __len__(self) -> int:
        return len(self._shapes)

    def __getitem__(self, i: int) -> Shape:
        return self._shapes[i]
