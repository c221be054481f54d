"""Vertex maps of pairs of shapes: each computed once, many in parallel, kept in a cache where there is one.

A killed run leaves the pairs it has finished, and the next one goes on from there.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from itertools import chain
from typing import Protocol, cast

import numpy as np
from jaxtyping import Int

from lssd_learn.cache import Cache
from lssd_learn.collections.parallel import in_parallel
from lssd_learn.maps.pace import timed

STAGE = "vertex_maps"


class Maker(Protocol):
    """What computes the maps of one pair: at least "there" and "back"."""

    def pair(self, i: int, j: int) -> dict[str, np.ndarray]: ...

    def depends_on(self, i: int, j: int) -> list: ...


@dataclass
class StoredMaps:
    """(maker, i, j) → (V_j,) vertices of shape i and (V_i,) vertices of shape j, for i < j.

    Attributes:
        cache: None keeps them in memory.
        key: i, j and what else their maps depend on → the name of the entry.
    """

    cache: Cache | None = None
    key: Callable[[int, int, list], str] | None = None
    _inside: dict[tuple[int, int], dict[str, np.ndarray]] = field(default_factory=dict)

    def __call__(self, maker: Maker, i: int, j: int) -> tuple[Int[np.ndarray, " V_j"], Int[np.ndarray, " V_i"]]:
        arrays = self.entry(maker, i, j)
        return arrays["there"], arrays["back"]

    def entry(self, maker: Maker, i: int, j: int) -> dict[str, np.ndarray]:
        """All that is kept of a pair, by name."""
        if self.cache is None:
            if (i, j) not in self._inside:
                self._inside[i, j] = _compute(maker, i, j)
            return self._inside[i, j]
        return self.cache.get(STAGE, self._name(maker, i, j), lambda: _compute(maker, i, j))

    def prepare(self, maker: Maker, pairs: Sequence[tuple[int, int]], workers: int | None) -> None:
        """Compute what is missing of these pairs."""
        if self.cache is None:
            missing = [pair for pair in pairs if pair not in self._inside]
            begun = timed(lambda p: _one(p, maker, missing), missing, workers)
            rest = in_parallel(_one, range(len(begun), len(missing)), "maps", workers, maker, missing)
            self._inside |= dict(zip(missing, chain(begun, rest), strict=True))
            return
        names = [self._name(maker, i, j) for i, j in pairs]
        missing = [p for p, name in enumerate(names) if self.cache.load(STAGE, name) is None]
        arguments = maker, pairs, self.cache, names
        begun = timed(lambda p: _store(missing[p], *arguments), [pairs[p] for p in missing], workers)
        for _ in in_parallel(_store, missing[len(begun) :], "maps", workers, *arguments):
            pass

    def _name(self, maker: Maker, i: int, j: int) -> str:
        return cast(Callable[[int, int, list], str], self.key)(i, j, maker.depends_on(i, j))


def _compute(maker: Maker, i: int, j: int) -> dict[str, np.ndarray]:
    kept = maker.pair(i, j)
    return kept | {way: np.asarray(kept[way], np.int32) for way in ("there", "back")}


def _one(p: int, maker: Maker, pairs: Sequence[tuple[int, int]]) -> dict[str, np.ndarray]:
    return _compute(maker, *pairs[p])


def _store(p: int, maker: Maker, pairs: Sequence[tuple[int, int]], cache: Cache, names: Sequence[str]) -> None:
    cache.get(STAGE, names[p], lambda: _compute(maker, *pairs[p]))
