"""A region of shapes as a person names it: a part, a file, the vertices themselves."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from lssd_learn.collections.base import Collection
from lssd_learn.errors import InputError, reading

FILES = (".npy", ".txt")


def region_mask(region: str | Sequence[int], collection: Collection, vertices: int) -> np.ndarray:
    """(V,) bool mask of a region that is the same on all shapes of a collection.

    Args:
        region: one of `collection.parts`; a .npy or .txt file, or a list, of the numbers of vertices, or of a zero or
            one for every vertex.
        collection: names parts.
        vertices: V of its shapes.

    Raises:
        InputError: no such part or file, numbers that are no vertices, a region that is empty or everything.
    """
    if isinstance(region, str) and region in collection.parts:
        return np.asarray(collection.parts[region], dtype=bool)
    if isinstance(region, str) and Path(region).suffix not in FILES:
        known = ", ".join(collection.parts) or "a collection without named parts"
        raise InputError(f"task.region={region}: expected a .npy or .txt file, a list of vertices, or one of: {known}")
    numbers = np.asarray(_read(Path(region)) if isinstance(region, str) else region)
    if numbers.dtype == bool or (numbers.shape == (vertices,) and np.isin(numbers, (0, 1)).all()):
        mask = numbers.astype(bool)
    else:
        whole = numbers.ndim == 1 and numbers.dtype.kind in "iuf" and bool((numbers == np.round(numbers)).all())
        if not whole or not ((numbers >= 0) & (numbers < vertices)).all():
            raise InputError(f"task.region={_short(region)}: expected numbers of vertices, 0 to {vertices - 1:,}")
        mask = np.zeros(vertices, dtype=bool)
        mask[numbers.astype(int)] = True
    if mask.shape != (vertices,) or not mask.any() or mask.all():
        count = f"{mask.sum():,} of {mask.size:,}"
        raise InputError(f"task.region={_short(region)}: expected some of {vertices:,} vertices, got {count}")
    return mask


def _read(path: Path) -> np.ndarray:
    if not path.is_file():
        raise InputError(f"task.region={path}: no such file")
    with reading(path):
        try:
            return np.load(path) if path.suffix == ".npy" else np.loadtxt(path, ndmin=1)
        except (ValueError, EOFError) as error:
            raise InputError(f"{path}: expected numbers of vertices, or a zero or one for each: {error}") from None


def _short(region: str | Sequence[int]) -> str:
    return region if isinstance(region, str) else f"[{len(region)} numbers]"
