"""Some of the shapes of a collection as a collection of their own, with all that is known about them."""

from collections.abc import Iterable, Iterator, Mapping, Sequence

import numpy as np

from lssd_learn.cache import Cache, fingerprint
from lssd_learn.collections.base import Collection
from lssd_learn.collections.chosen import Chosen
from lssd_learn.errors import InputError


class Subset(Chosen):
    """The shapes at some positions of a collection, and all that it knows of them: also `collection[positions]`.

    Args:
        collection: n shapes.
        positions: of them, each once, in the order they shall have.

    Raises:
        InputError: positions out of range or twice, none at all.
    """

    def __init__(self, collection: Collection, positions: Sequence[int]):
        n, some = len(collection), [int(i) for i in positions]
        if not some or not all(0 <= i < n for i in some) or len(set(some)) < len(some):
            raise InputError(f"positions: expected some of 0 to {n - 1}, each once, got {some}")
        super().__init__([(collection, i) for i in some])
        self.collection, self.positions = collection, some
        self.parameter_names, self.up, self.truth = collection.parameter_names, collection.up, collection.truth
        if collection.parameters is not None:
            self.parameters = collection.parameters[self.positions]
        self.groups = {name: np.asarray(labels)[self.positions] for name, labels in collection.groups.items()}
        self.covariates = {name: values[self.positions] for name, values in collection.covariates.items()}
        self.vertex_maps = _Between(collection.vertex_maps, self.positions)

    @property
    def parts(self) -> Mapping[str, np.ndarray]:
        """(V,) bool masks."""
        return self.collection.parts

    @property
    def key(self) -> str | None:
        """Depends on the positions and on all of the collection: landmarks and maps are its own."""
        whole = self.collection.key
        return None if whole is None else fingerprint("subset", whole, self.positions)

    def check(self) -> Sequence[str]:
        return self.collection.check()

    @property
    def connectivities(self) -> Sequence[str | None] | None:
        whole = self.collection.connectivities
        return None if whole is None else [whole[i] for i in self.positions]

    def keep_in(self, cache: Cache | None, workers: int | None = None) -> None:
        self.collection.keep_in(cache, workers)

    def remind(self, warnings: Iterable[str]) -> None:
        self.collection.remind(warnings)

    def told(self) -> Sequence[str]:
        return self.collection.told()

    def changes(self) -> Sequence[Mapping[str, object]]:
        rows = self.collection.changes()
        return [rows[i] for i in self.positions] if len(rows) else ()

    def lacks(self, what: str, name: str | None = None) -> str:
        return self.collection.lacks(what, name)


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


Collection.part = Subset  # here, since `base.py` cannot know what is made of it
