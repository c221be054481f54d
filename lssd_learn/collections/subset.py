"""Some of the shapes of a collection as a collection of their own, with all that is known about them."""

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from lssd_learn.cache import Cache, fingerprint
from lssd_learn.collections.base import Collection
from lssd_learn.errors import InputError
from lssd_learn.shapes import Shape


class Subset(Collection):
    """The shapes at some positions of a collection; what is computed of them is found where the collection left it.

    Args:
        collection: n shapes.
        positions: of them, each once, in the order they shall have.

    Raises:
        InputError: positions out of range or twice, none at all.
    """

    def __init__(self, collection: Collection, positions: Sequence[int]):
        self.collection, self.positions = collection, [int(i) for i in positions]
        n = len(collection)
        if not self.positions or not all(0 <= i < n for i in self.positions) or len(set(self.positions)) < len(self):
            raise InputError(f"positions: expected some of 0 to {n - 1}, each once, got {self.positions}")
        self.names = [collection.names[i] for i in self.positions]
        self.parameter_names, self.up = collection.parameter_names, collection.up
        if collection.parameters is not None:
            self.parameters = collection.parameters[self.positions]
        self.groups = {name: np.asarray(labels)[self.positions] for name, labels in collection.groups.items()}
        self.landmarks = _Picked(collection.landmarks, self.positions) if len(collection.landmarks) else ()
        self.vertex_maps = _Between(collection.vertex_maps, self.positions)

    def __len__(self) -> int:
        return len(self.positions)

    def __getitem__(self, i: int) -> Shape:
        return self.collection[self.positions[i]]

    @property
    def parts(self) -> Mapping[str, np.ndarray]:
        """(V,) bool masks."""
        return self.collection.parts

    @property
    def key(self) -> str | None:
        """Depends on the positions and on all of the collection: landmarks and maps are its own."""
        whole = self.collection.key
        return None if whole is None else fingerprint("subset", whole, self.positions)

    def check(self) -> None:
        self.collection.check()

    def keep_in(self, cache: Cache | None, workers: int | None = None) -> None:
        self.collection.keep_in(cache, workers)

    def shape_key(self, i: int) -> str | None:
        return self.collection.shape_key(self.positions[i])


class _Picked(Sequence):
    """Some items of a sequence that makes them when asked for."""

    def __init__(self, items: Sequence, positions: Sequence[int]):
        self._items, self._positions = items, positions

    def __len__(self) -> int:
        return len(self._positions)

    def __getitem__(self, i: int):
        return self._items[self._positions[i]]


class _Between(Mapping):
    """The maps between some of the shapes, by their new positions, made when asked for."""

    def __init__(self, maps: Mapping, positions: Sequence[int]):
        new = {old: i for i, old in enumerate(positions)}
        self._maps, self._old = maps, {(new[a], new[b]): (a, b) for a, b in maps if a in new and b in new}

    def __len__(self) -> int:
        return len(self._old)

    def __iter__(self) -> Iterator[tuple[int, int]]:
        return iter(self._old)

    def __getitem__(self, pair: tuple[int, int]) -> np.ndarray:
        return self._maps[self._old[pair]]
