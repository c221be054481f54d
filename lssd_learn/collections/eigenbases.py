"""The eigenbases of a whole collection: computed in parallel, cached one by one, opened when asked for.

The moments of the coordinates lie beside them, in a stage of their own that is made only when somebody asks for them.
"""

import logging
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from functools import partial
from typing import cast

import numpy as np

from lssd_learn.cache import DEFAULT, Cache, fingerprint
from lssd_learn.collections.base import Collection
from lssd_learn.collections.given import as_collection
from lssd_learn.collections.parallel import in_parallel
from lssd_learn.collections.picking import Picking
from lssd_learn.errors import InputError
from lssd_learn.shapes import Eigenbasis, Shape
from lssd_learn.shapes.eigenbasis import eigenbasis_as_is
from lssd_learn.shapes.given import Given
from lssd_learn.shapes.moments import Moments, moments

log = logging.getLogger(__name__)

STAGE = "eigenbasis"
VERSION = 3  # goes up whenever the same shape and arguments give another eigenbasis
MOMENTS = "moments"
MOMENTS_VERSION = 2  # goes up whenever the same eigenbasis gives other moments


class Bases(Picking[Eigenbasis]):
    """Eigenbases in memory; some of them, as `bases[2:5]` or `bases[mask]`, are such a sequence again."""

    def __init__(self, bases: Iterable[Eigenbasis]):
        self._bases = list(bases)

    def __len__(self) -> int:
        return len(self._bases)

    def __getitem__(self, i: int) -> Eigenbasis:
        return self._bases[i]

    def _some(self, positions: list[int]) -> "Bases":
        return Bases(self._bases[i] for i in positions)


class StoredBases(Picking[Eigenbasis]):
    """Eigenbases that lie in a cache, memory-mapped one at a time; some of them, as `bases[mask]`, stay there.

    Args:
        cache: where they lie.
        keys: one a shape.
        names: one a shape, for messages.
        remedy: the command that makes a missing one again.
        shapes: position → the shape, whose moments are computed from it; None finds those in the cache alone.

    Raises:
        InputError: on access, an entry is missing; names the command to make it again.
    """

    def __init__(
        self,
        cache: Cache,
        keys: Sequence[str],
        names: Sequence[str],
        remedy: str = "",
        shapes: Callable[[int], Shape] | None = None,
    ):
        self.cache, self.keys, self.names, self.remedy = cache, list(keys), list(names), remedy
        self.shapes = shapes
        self._moments: dict[int, Moments] = {}  # small matrices, asked for again and again

    def __repr__(self) -> str:
        return f"StoredBases({len(self):,} eigenbases in {self.cache.root})"

    def __len__(self) -> int:
        return len(self.keys)

    def __getitem__(self, i: int) -> Eigenbasis:
        arrays = self.cache.load(STAGE, self.keys[i])
        if arrays is None:
            remedy = f"; make it again with: {self.remedy}" if self.remedy else ""
            raise InputError(
                f"eigenbasis of {self.names[i]}: {self.cache.path(STAGE, self.keys[i])} is missing{remedy}"
            )
        return _from_arrays(arrays, partial(self.moments, i))

    def moments(self, i: int) -> Moments | None:
        """Those of shape i, whose eigenbasis is not opened where they are known; None where nobody knows the shape."""
        if i not in self._moments:
            arrays = self.cache.load(MOMENTS, self._moments_key(i))
            if arrays is None and self.shapes is not None:
                arrays = self.cache.get(MOMENTS, self._moments_key(i), partial(self._measure, i))
            if arrays is None:
                return None
            self._moments[i] = Moments(arrays["form"], arrays["coordinates"])
        return self._moments[i]

    def measure(self, workers: int | None = None, before: Callable[[], object] | None = None) -> None:
        """Make what moments are missing, by several processes.

        Args:
            workers: see `in_parallel`.
            before: called if any is to be made, before it is: the eigenbases have to be there.
        """
        missing = [i for i in range(len(self)) if self.cache.load(MOMENTS, self._moments_key(i)) is None]
        if missing and self.shapes is not None:
            if before is not None:
                before()
            list(in_parallel(_keep_moments, missing, "moments", workers, self))

    def _moments_key(self, i: int) -> str:
        return fingerprint(MOMENTS, MOMENTS_VERSION, self.keys[i])

    def _measure(self, i: int) -> dict[str, np.ndarray]:
        found = _moments_of(cast(Callable[[int], Shape], self.shapes), i, self[i])
        return {"form": found.form, "coordinates": found.coordinates}

    def _some(self, positions: list[int]) -> "StoredBases":
        keys, names = ([items[i] for i in positions] for items in (self.keys, self.names))
        shapes = None if self.shapes is None else partial(_picked, self.shapes, positions)
        return StoredBases(self.cache, keys, names, self.remedy, shapes)


def eigenbases(
    shapes: Sequence[Given] | str,
    k: int,
    laplacian: str = "auto",
    cache: Cache | None = DEFAULT,
    workers: int | None = None,
    before: Callable[[], None] | None = None,
) -> Bases | StoredBases:
    """The first k eigenfunctions of every shape of a collection.

    Eigenfunctions are kept in float32, from a float64 computation: half the room, and far more than the maps need.

    Args:
        shapes: a collection, a folder or a sequence of shapes, see `as_collection`.
        k, laplacian: see `lssd_learn.shapes.eigenbasis`.
        cache: where eigenbases are kept; None keeps them in memory, as does a collection without a key.
        workers: see `in_parallel`.
        before: called if any is to be computed, before it is: what else would stop the run is best known then.

    Raises:
        InputError: a shape has too few vertices, or cannot be used; names it.

    Examples:
        >>> import lssd_learn as lssd
        >>> bases = lssd.eigenbases(lssd.collections.Bumps(subdivisions=2), k=10, cache=None)
        >>> len(bases), bases[0].k
        (4, 10)
    """
    collection = as_collection(shapes)
    if cache is None or collection.key is None:
        collection.check()
        if before is not None:
            before()
        everything = list(range(len(collection)))
        arrays = in_parallel(_compute, everything, "eigenbases", workers, collection, k, laplacian)
        return Bases(_measurable(_from_arrays(each), collection, i) for i, each in enumerate(arrays))
    keys = basis_keys(collection, k, laplacian)
    missing = [i for i, key in enumerate(keys) if cache.load(STAGE, key) is None]
    if missing:
        collection.check()  # here, where the user sees what it has to say, and not in a worker
        if before is not None:
            before()
        list(in_parallel(_store, missing, "eigenbases", workers, collection, k, laplacian, cache, keys))
    return StoredBases(cache, keys, collection.names, shapes=collection.__getitem__)


def basis_keys(collection: Collection, k: int, laplacian: str) -> list[str]:
    """The cache's key of each shape's eigenbasis."""
    return [fingerprint(STAGE, VERSION, collection.shape_key(i), k, laplacian) for i in range(len(collection))]


def _compute(i: int, collection: Collection, k: int, laplacian: str) -> dict[str, np.ndarray]:
    shape = collection[i]
    try:
        basis = eigenbasis_as_is(shape, k, laplacian)
    except InputError as error:
        raise InputError(f"{collection.names[i]}: {error}") from error
    return {
        "evals": basis.evals,
        "evecs": np.ascontiguousarray(basis.evecs, np.float32),  # as it comes back from the cache, to the last bit
        "mass": basis.mass,
        "connectivity": np.array(basis.connectivity or ""),
    }


def _store(i: int, collection: Collection, k: int, laplacian: str, cache: Cache, keys: Sequence[str]) -> None:
    cache.get(STAGE, keys[i], lambda: _compute(i, collection, k, laplacian))


def _from_arrays(arrays: dict[str, np.ndarray], measure: Callable[[], Moments | None] | None = None) -> Eigenbasis:
    connectivity = str(arrays["connectivity"]) or None
    return Eigenbasis(arrays["evals"], arrays["evecs"], arrays["mass"], connectivity, measure)


def _measurable(basis: Eigenbasis, collection: Collection, i: int) -> Eigenbasis:
    return replace(basis, measure=partial(_moments_of, collection.__getitem__, i, basis))


def _moments_of(shapes: Callable[[int], Shape], i: int, basis: Eigenbasis) -> Moments:
    return moments(shapes(i).vertices, basis.mass, basis.evecs)


def _keep_moments(i: int, bases: StoredBases) -> None:
    bases.moments(i)


def _picked(shapes: Callable[[int], Shape], positions: Sequence[int], i: int) -> Shape:
    return shapes(positions[i])
