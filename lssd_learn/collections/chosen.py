"""Some shapes of one or several collections as a collection of their own."""

from collections.abc import Mapping, Sequence
from functools import cached_property

import numpy as np

from lssd_learn.cache import fingerprint
from lssd_learn.collections.base import Collection
from lssd_learn.shapes import Shape


class Chosen(Collection):
    """The shapes that were picked; what is computed of them is found where their collections left it.

    Args:
        picks: a collection and a position in it for each shape.
    """

    def __init__(self, picks: Sequence[tuple[Collection, int]]):
        self.picks = [(collection, int(i)) for collection, i in picks]
        self.names = [collection.names[i] for collection, i in self.picks]
        self.up = self.picks[0][0].up if self.picks else None

    def __len__(self) -> int:
        return len(self.picks)

    def __getitem__(self, i: int) -> Shape:
        collection, position = self.picks[i]
        return collection[position]

    @cached_property
    def key(self) -> str | None:
        """Depends on the shapes that were picked, and on nothing else of their collections."""
        keys = [self.shape_key(i) for i in range(len(self))]
        return None if None in keys else fingerprint("chosen", keys)

    @property
    def landmarks(self) -> Sequence[Mapping[str, int]]:
        """Of each shape, where all the collections know them."""
        known = {id(collection): len(collection.landmarks) for collection, _ in self.picks}
        return _Landmarks(self.picks) if all(known.values()) else ()

    def marked(self, i: int) -> Mapping[str, np.ndarray]:
        collection, position = self.picks[i]
        return collection.marked(position)

    def shape_key(self, i: int) -> str | None:
        collection, position = self.picks[i]
        return collection.shape_key(position)

    def space(self, i: int) -> str:
        collection, position = self.picks[i]
        return collection.space(position)


class _Landmarks(Sequence):
    """Those of some shapes, asked for one by one: a folder reads points to place them."""

    def __init__(self, picks: Sequence[tuple[Collection, int]]):
        known = {id(collection): collection.landmarks for collection, _ in picks}
        self._picks = [(known[id(collection)], i) for collection, i in picks]

    def __len__(self) -> int:
        return len(self._picks)

    def __getitem__(self, i: int) -> Mapping[str, int]:
        landmarks, position = self._picks[i]
        return landmarks[position]
