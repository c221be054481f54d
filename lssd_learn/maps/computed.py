"""The maps of a collection whose shapes are not in correspondence, computed pair by pair: at once or as asked for.

Where a correspondence is known, `correspondence="none"` computes them all the same: to see what they are worth.
"""

import logging
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from inspect import Signature, signature
from typing import Any, ClassVar

import numpy as np
from jaxtyping import Float, Int

from lssd_learn.cache import Cache
from lssd_learn.collections import Collection
from lssd_learn.errors import InputError
from lssd_learn.maps.correspondence import from_correspondence
from lssd_learn.maps.kernel_matching import KernelMatching, matched_vertices
from lssd_learn.maps.pairs import PairMaps
from lssd_learn.maps.registration import Registration, registered_vertices
from lssd_learn.maps.stored import StoredMaps
from lssd_learn.shapes import Eigenbasis, Shape

log = logging.getLogger(__name__)

FIRST = 10  # eigenvalues that say which of two shapes is the first


@dataclass(frozen=True)
class Nothing:
    """The choices of a method that leaves none."""


class ComputedMaps(PairMaps):
    """Vertex identity between shapes of one connectivity, computed maps elsewhere: both directions of a pair at once.

    The vertex maps of the collection are not used. Subclasses give `vertex_maps`, and `depends_on` where a pair's maps
    depend on more than its two shapes. What a method may choose is said once, by the dataclass `Choices`: its fields
    are arguments here, keys of the yaml and part of the cache key.

    Which of two shapes is bent, or otherwise treated as the first, is said by the shapes, not by their places in the
    collection: groups are listed one after the other, and a method that is not symmetric would tell them apart. Of a
    new shape and one of the `known` it is the known one.

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
    version = 2  # goes up whenever the same two shapes and arguments give other maps: it is part of the cache key
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
        """(V_j,) for each vertex of shape j one of shape i, and (V_i,) the other way, shape i the first."""
        raise NotImplementedError

    def vertices(self, i: int, j: int) -> Int[np.ndarray, " V_j"]:
        """(V_j,) for each vertex of shape j one of shape i, of the map that is kept."""
        on_b, on_a = self._stored(self, min(i, j), max(i, j))
        return on_b if i < j else on_a

    def pair(self, i: int, j: int) -> dict[str, np.ndarray]:
        """What is kept of a pair: "there" and "back" of `vertex_maps`, and more where a subclass has more."""
        if self._leads(i, j):
            return self._pair(i, j)
        return _turned_round(self._pair(j, i))

    def _pair(self, i: int, j: int) -> dict[str, np.ndarray]:
        """The same, shape i the first."""
        there, back = self.vertex_maps(i, j)
        return {"there": there, "back": back}

    def _leads(self, i: int, j: int) -> bool:
        """Whether shape i is the first of the two: the known one, or the one of lower frequencies."""
        if (i < self.known) != (j < self.known):
            return i < j
        ours, theirs = ((self._pitch(k), k) for k in (i, j))
        return ours < theirs

    def _pitch(self, i: int) -> float:
        """The sum of the first eigenvalues at unit area."""
        basis = self._bases[i]
        return float(np.sum(basis.evals[1:FIRST])) * basis.area

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


def _turned_round(kept: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """What is kept of a pair, of the same two shapes in the other order: names begin with the way they are about, and
    what is known of both shapes is (2,)."""
    other = {"there": "back", "back": "there"}
    found = {}
    for name, values in kept.items():
        way, *rest = name.split("_")
        found["_".join([other.get(way, way), *rest])] = values[::-1] if name == "unreached" else values
    return found


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
