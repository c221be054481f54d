"""The maps of a collection whose shapes are not in correspondence, computed pair by pair: at once or as asked for.

Where a correspondence is known, `correspondence="none"` computes them all the same: to see what they are worth.
"""

import logging
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from inspect import Signature, signature
from typing import Any, ClassVar

import numpy as np
from jaxtyping import Float, Int

from lssd_learn.cache import Cache
from lssd_learn.collections import Collection
from lssd_learn.errors import InputError, check_whole
from lssd_learn.maps.adjoint import adjoint
from lssd_learn.maps.common_landmarks import SharedLandmarks, check_landmarks
from lssd_learn.maps.correspondence import from_correspondence
from lssd_learn.maps.kernel_matching import KernelMatching, matched_vertices
from lssd_learn.maps.landmarks import Landmarks, landmark_vertices
from lssd_learn.maps.pairs import PairMaps
from lssd_learn.maps.registration import Registration, registered_vertices
from lssd_learn.maps.spline import Spline, spline_vertices
from lssd_learn.maps.stored import StoredMaps
from lssd_learn.maps.zoomout import zoomed_vertices
from lssd_learn.shapes import Eigenbasis, Shape

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Nothing:
    """The choices of a method that leaves none."""


class ComputedMaps(PairMaps):
    """Vertex identity between shapes of one connectivity, computed maps elsewhere: both directions of a pair at once.

    The vertex maps of the collection are not used. Subclasses give `vertex_maps`, and `depends_on` where a pair's maps
    depend on more than its two shapes. What a method may choose is said once, by the dataclass `Choices`: its fields
    are arguments here, keys of the yaml and part of the cache key.

    Args:
        bases, collection: see `PairMaps`.
        correspondence: "auto", or "none": shapes of one connectivity are no exception.
        choices: of the method.

    Attributes:
        how: the choices.

    Raises:
        InputError: another correspondence, a choice out of its range.
    """

    Choices: ClassVar[type] = Nothing
    how: Any
    version = 1  # goes up whenever the same two shapes and arguments give other maps: it is part of the cache key
    computed = True

    def __init_subclass__(cls, **arguments):
        """The signature with the choices spelt out: what a value of the yaml may be is read there."""
        super().__init_subclass__(**arguments)
        own = [p for p in signature(cls.__init__).parameters.values() if p.kind is not p.VAR_KEYWORD][1:]
        chosen = signature(cls.Choices).parameters.values()
        cls.__signature__ = Signature([*own, *(p.replace(kind=p.KEYWORD_ONLY) for p in chosen)])

    def __init__(self, bases: Sequence[Eigenbasis], collection: Collection, correspondence: str = "auto", **choices):
        super().__init__(bases, collection)
        self.how = self._chosen(correspondence, **choices)
        self._ignored = correspondence == "none"
        self._stored = StoredMaps()

    @classmethod
    def _chosen(cls, correspondence: str = "auto", **choices) -> Any:
        """The choices, looked at."""
        if correspondence not in ("auto", "none"):
            raise InputError(f"maps.correspondence={correspondence}: expected auto or none")
        return cls.Choices(**choices)

    @classmethod
    def check(cls, collection: Collection, every_pair: bool, **arguments) -> None:
        cls._chosen(**arguments)

    @classmethod
    def defaults(cls) -> dict[str, Any]:
        """All that may be chosen, as it is where nothing is said."""
        return {name: p.default for name, p in signature(cls).parameters.items() if p.default is not p.empty}

    @property
    def is_identity(self) -> bool:
        return not self._ignored and super().is_identity

    def _correspond(self, i: int, j: int) -> bool:
        return not self._ignored and super()._correspond(i, j)

    def vertex_maps(self, i: int, j: int) -> tuple[Int[np.ndarray, " V_j"], Int[np.ndarray, " V_i"]]:
        """(V_j,) for each vertex of shape j one of shape i, and (V_i,) the other way; i < j."""
        raise NotImplementedError

    def vertices(self, i: int, j: int) -> Int[np.ndarray, " V_j"]:
        """(V_j,) for each vertex of shape j one of shape i, of the map that is kept."""
        on_b, on_a = self._stored(self, min(i, j), max(i, j))
        return on_b if i < j else on_a

    def pair(self, i: int, j: int) -> dict[str, np.ndarray]:
        """What is kept of a pair, i < j: "there" and "back" of `vertex_maps`, and more where a subclass has more."""
        there, back = self.vertex_maps(i, j)
        return {"there": there, "back": back}

    def __call__(self, i: int, j: int) -> Float[np.ndarray, "k_j k_i"]:
        if self._correspond(i, j):
            return from_correspondence(self._bases[i], self._bases[j])
        return from_correspondence(self._bases[i], self._bases[j], self.vertices(i, j))

    def prepare(self, pairs: Iterable[tuple[int, int]], workers: int | None = None) -> None:
        wanted = sorted({(min(pair), max(pair)) for pair in pairs if not self._correspond(*pair)})
        self._stored.prepare(self, wanted, workers)

    def keep_in(self, cache: Cache, key: Callable[[int, int, list], str]) -> None:
        self._stored = StoredMaps(cache, key)

    def depends_on(self, i: int, j: int) -> list:
        """What the maps of a pair depend on beside its two shapes, in plain words and numbers."""
        return []

    def _both(self, i: int, j: int) -> tuple[Eigenbasis, Eigenbasis, Shape, Shape]:
        return self._bases[i], self._bases[j], self._collection[i], self._collection[j]


class _MarkedMaps(ComputedMaps):
    """Those that go by landmarks: `landmarks` of those that two shapes share, see `SharedLandmarks`; None is all."""

    def __init__(
        self,
        bases: Sequence[Eigenbasis],
        collection: Collection,
        landmarks: int | None = None,
        correspondence: str = "auto",
        **choices,
    ):
        super().__init__(bases, collection, correspondence, **choices)
        self._landmarks = landmarks

    @classmethod
    def check(cls, collection: Collection, every_pair: bool, landmarks: int | None = None, **arguments) -> None:
        super().check(collection, every_pair, **arguments)
        check_landmarks(collection, landmarks, **arguments)

    @cached_property
    def _shared(self) -> SharedLandmarks:
        return SharedLandmarks(self._collection, self._landmarks)

    def depends_on(self, i: int, j: int) -> list:
        return [vertices.tolist() for vertices in self._shared.of_pair(i, j)]


class LandmarkMaps(_MarkedMaps):
    """`maps=landmarks`: from the landmarks that each two shapes of the collection share.

    Args:
        bases, collection, correspondence: see `ComputedMaps`.
        landmarks: how many of them to use, see `SharedLandmarks`; None is all.
        choices: see `landmarks.Landmarks`.

    Raises:
        InputError: on the first pair, fewer than three landmarks that two shapes share, or all of a shape on a line.
    """

    Choices = Landmarks
    how: Landmarks

    def vertex_maps(self, i: int, j: int) -> tuple[Int[np.ndarray, " V_j"], Int[np.ndarray, " V_i"]]:
        return self._one_way(i, j), self._one_way(j, i)

    def _one_way(self, i: int, j: int) -> np.ndarray:
        return landmark_vertices(self._bases[i], self._bases[j], *self._shared.of_pair(i, j), self.how)


@dataclass(frozen=True)
class Adjoint:
    """The choices of `maps=adjoint`.

    Attributes:
        functions: that the pair of maps is computed for.
        trusted: of these, the ones that ZoomOut starts from.
        refined: functions at the end of ZoomOut; None leaves it out.

    Raises:
        InputError: a number out of its range.
    """

    functions: int = 60
    trusted: int = 30
    refined: int | None = 40

    def __post_init__(self):
        check_whole("maps.functions", self.functions, 1)
        check_whole("maps.trusted", self.trusted, 1, self.functions)


class AdjointMaps(_MarkedMaps):
    """`maps=adjoint`: both directions in one, regularised by each other; with landmarks where the collection has any.

    Args:
        bases, collection, correspondence: see `ComputedMaps`.
        landmarks: as in `LandmarkMaps`; 0 uses none.
        choices: see `Adjoint`.

    Raises:
        InputError: on the first pair, landmarks that do not do.
    """

    Choices = Adjoint
    how: Adjoint

    @classmethod
    def check(cls, collection: Collection, every_pair: bool, landmarks: int | None = None, **arguments) -> None:
        if landmarks != 0 and any(collection.landmarks):
            super().check(collection, every_pair, landmarks, **arguments)
        else:
            cls._chosen(**arguments)

    @cached_property
    def _shared(self) -> SharedLandmarks | None:
        if self._landmarks == 0 or not any(self._collection.landmarks):
            log.warning("maps=adjoint: without landmarks; symmetric shapes may be mapped mirrored")
            return None
        return SharedLandmarks(self._collection, self._landmarks)

    def _marks(self, i: int, j: int) -> tuple[np.ndarray, np.ndarray]:
        none = np.empty(0, dtype=int)
        return (none, none) if self._shared is None else self._shared.of_pair(i, j)

    def depends_on(self, i: int, j: int) -> list:
        return [vertices.tolist() for vertices in self._marks(i, j)]

    def vertex_maps(self, i: int, j: int) -> tuple[Int[np.ndarray, " V_j"], Int[np.ndarray, " V_i"]]:
        a, b = (basis.truncate(min(self.how.functions, basis.k)) for basis in (self._bases[i], self._bases[j]))
        few = self.how.trusted
        there, back = (C[:few, :few] for C in adjoint(a, b, *self._marks(i, j)))
        return zoomed_vertices(a, b, there, self.how.refined), zoomed_vertices(b, a, back, self.how.refined)


class RegistrationMaps(ComputedMaps):
    """`maps=registration`: the one shape bent onto the other, for shapes that stand alike.

    Args:
        bases, collection, correspondence: see `ComputedMaps`.
        choices: see `registration.Registration`.
    """

    Choices = Registration
    how: Registration

    def vertex_maps(self, i: int, j: int) -> tuple[Int[np.ndarray, " V_j"], Int[np.ndarray, " V_i"]]:
        return registered_vertices(*self._both(i, j), self.how)


class KernelMatchingMaps(ComputedMaps):
    """`maps=kernel_matching`: nothing but the shapes is needed, standing upright and facing one way.

    Args:
        bases, collection, correspondence: see `ComputedMaps`.
        choices: see `kernel_matching.KernelMatching`.
    """

    Choices = KernelMatching
    how: KernelMatching

    def vertex_maps(self, i: int, j: int) -> tuple[Int[np.ndarray, " V_j"], Int[np.ndarray, " V_i"]]:
        return matched_vertices(*self._both(i, j), self.how)


class SplineMaps(_MarkedMaps):
    """`maps=spline`: from landmarks in space, for rigid shapes of one kind, such as bones.

    Args:
        bases, collection, correspondence: see `ComputedMaps`.
        landmarks: as in `LandmarkMaps`.
        choices: see `spline.Spline`.

    Raises:
        InputError: on the first pair, fewer than four landmarks that two shapes share, or all of a shape in a plane.
    """

    Choices = Spline
    how: Spline

    def vertex_maps(self, i: int, j: int) -> tuple[Int[np.ndarray, " V_j"], Int[np.ndarray, " V_i"]]:
        shapes = self._collection
        return spline_vertices(shapes[i], shapes[j], *self._shared.of_pair(i, j), self.how)
