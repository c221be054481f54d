"""These of those: what makes slices, lists and masks of a lazy sequence a lazy sequence of the same kind."""

from collections.abc import Callable, Sequence
from functools import wraps
from operator import index
from typing import TYPE_CHECKING, Any, TypeAlias, TypeVar, overload

import numpy as np

from lssd_learn.errors import InputError

T = TypeVar("T")

Some: TypeAlias = slice | Sequence[int] | np.ndarray  # what stands for several positions


class Picking(Sequence[T]):
    """A sequence whose subclasses give `__len__`, `__getitem__` (of a whole number from 0) and `_some`.

    `items[i]` is one item, also from the end; `items[2:5]`, `items[[4, 0]]` and `items[mask]` are some of them, and no
    item is made until it is asked for.
    """

    def __init_subclass__(cls, **arguments):
        super().__init_subclass__(**arguments)
        if "__getitem__" in vars(cls):
            cls.__getitem__ = _picking(vars(cls)["__getitem__"])

    if TYPE_CHECKING:  # what becomes of the subclasses' own

        @overload
        def __getitem__(self, index: int) -> T: ...
        @overload
        def __getitem__(self, index: Some) -> "Picking[T]": ...
        def __getitem__(self, index: int | Some) -> "T | Picking[T]": ...

    def _some(self, positions: list[int]) -> "Picking[T]":
        """The items at these positions, in this order."""
        raise NotImplementedError


def positions(wanted: Any, n: int) -> list[int]:
    """The positions among n that a slice, a list or array of whole numbers, or a mask (n,) bool stands for.

    Raises:
        InputError: a mask of another length, or something else.
        IndexError: past the end.
    """
    if isinstance(wanted, slice):
        return list(range(n)[wanted])
    asked = np.asarray(wanted)
    if asked.dtype == bool:
        if asked.shape != (n,):
            raise InputError(f"mask: expected one truth value for each of {n}, got {asked.shape}")
        return np.flatnonzero(asked).tolist()
    if asked.ndim != 1 or (len(asked) and asked.dtype.kind not in "iu"):
        raise InputError(f"index: expected a whole number, a slice, a list of numbers or a mask, got {wanted!r}")
    return [range(n)[int(i)] for i in asked]


def _picking(one: Callable[[Any, int], T]) -> Callable:
    @wraps(one)
    def get(self, i):
        if hasattr(type(i), "__index__") and np.ndim(i) == 0:
            return one(self, range(len(self))[index(i)])  # IndexError past the end, negative counts from it
        return self._some(positions(i, len(self)))

    return get
