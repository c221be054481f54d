"""Which points of the shapes of a benchmark correspond, as benchmarks are distributed: three layouts of text files.

    template   a file a shape, NAME.vts: line v is the vertex that is vertex v of a template (FAUST, SCAPE and SMAL
               remeshed)
    reference  a file a shape but for one, NAME.vts or NAME_ref.txt: line v is the vertex of the reference, which has no
               file, that vertex v of the shape is (TOPKIDS)
    pairs      a file a pair, A_B.map: line v is the vertex of B that is vertex v of A (SHREC'19)

They lie beside the shapes or in a folder of their own, are .vts, .map, .txt or .mat (of one vector), and count from 1.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import permutations
from pathlib import Path

import numpy as np
from scipy.io import loadmat

from lssd_learn.collections.reading.listing import read_indices
from lssd_learn.collections.reading.names import composed
from lssd_learn.errors import InputError, reading, some_of

SUFFIXES = (".vts", ".map", ".txt", ".mat")
FOLDERS = ("corres", "corr", "correspondences", "maps", "groundtruth", "gt")
FIRST = 1  # the number of the first vertex


@dataclass(frozen=True, eq=False)
class Truth:
    """Where the correspondences of n shapes stand.

    Attributes:
        files: (i,) of a shape or (i, j) of a pair → its file.
        reference: the shape that the files of the others lead to; None in the other two layouts.
        names: of the shapes.
    """

    files: Mapping[tuple[int, ...], Path]
    reference: int | None
    names: Sequence[str]

    @property
    def pairs(self) -> list[tuple[int, int]]:
        """(source, target) of those that are known, in the direction in which the benchmark has them."""
        if self.reference is not None:
            return [(self.reference, i) for (i,) in self.files]
        if any(len(shapes) == 2 for shapes in self.files):
            return [(i, j) for i, j in self.files]
        return list(permutations(range(len(self.names)), 2))

    def known(self, i: int, j: int, sizes: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
        """(m,) vertices of shape i and (m,) the same points on shape j, of the files as they are, counted from 0.

        Args:
            i, j: one of `pairs`.
            sizes: the numbers of vertices of the two files.

        Raises:
            InputError: a file that cannot be read, or does not fit its shapes.
        """
        if (i, j) in self.files:
            there = self._read((i, j), sizes[1], sizes[0])
            return np.arange(sizes[0]), there
        if self.reference is not None:
            return self._read((j,), sizes[0], sizes[1]), np.arange(sizes[1])
        here, there = self._read((i,), sizes[0]), self._read((j,), sizes[1])
        if len(here) != len(there):
            raise InputError(
                f"{self.files[j,]}: expected {len(here)} vertices, one for each of the template as in "
                f"{self.files[i,].name}, got {len(there)}"
            )
        return here, there

    def _read(self, shapes: tuple[int, ...], vertices: int, count: int | None = None) -> np.ndarray:
        """The numbers in a file, from 0 to below `vertices`, `count` of them where that is known."""
        file = self.files[shapes]
        found = _vector(file) if file.suffix.lower() == ".mat" else read_indices(file)
        if count is not None and len(found) != count:
            raise InputError(
                f"{file}: expected {count} numbers, one for each vertex of {self.names[shapes[0]]}, got {len(found)}"
            )
        if len(found) == 0 or found.min() < FIRST or found.max() > vertices:
            some = "none" if len(found) == 0 else f"{found.min()} to {found.max()}"
            raise InputError(f"{file}: expected vertices counted from 1, up to {vertices}, got {some}")
        return found - FIRST


def find_truth(path: Path, shapes: Path, names: Sequence[str]) -> Truth:
    """The correspondences of a benchmark.

    Args:
        path: its folder.
        shapes: where the shapes are, `path` or a folder in it.
        names: of the shapes.

    Raises:
        InputError: there are none, or not of all shapes.
    """
    position = {name: i for i, name in enumerate(names)}
    folders = [path / name for name in FOLDERS if (path / name).is_dir()] or [shapes]
    files: dict[tuple[int, ...], Path] = {}
    for folder in folders:
        with reading(folder):
            listed = sorted(file for file in folder.iterdir() if file.suffix.lower() in SUFFIXES)
        for file in listed:
            meant = _shapes_of(composed(file.stem), position)
            if meant in files:
                raise InputError(
                    f"{folder}: expected one file a shape or pair, got {files[meant].name} and {file.name}"
                )
            if meant is not None:
                files[meant] = file
    pairs = {shapes: file for shapes, file in files.items() if len(shapes) == 2}
    lacking = [name for name, i in position.items() if (i,) not in files]
    if pairs:
        return Truth(pairs, None, names)
    if len(lacking) > 1 or not files:
        where = " or ".join(str(folder) for folder in folders)
        raise InputError(
            f"{where}: expected correspondences, NAME.vts of each shape, of each but one, or A_B.map of pairs (.txt "
            f"and .mat do too); there is none of {some_of(lacking)}"
        )
    return Truth(files, position[lacking[0]] if lacking else None, names)


def _shapes_of(stem: str, position: Mapping[str, int]) -> tuple[int, ...] | None:
    """The one or two shapes that a file is named after; None for others."""
    for name in (stem, stem.removesuffix("_ref")):
        if name in position:
            return (position[name],)
    words = stem.split("_")
    splits = [("_".join(words[:n]).rstrip("_"), "_".join(words[n:]).lstrip("_")) for n in range(1, len(words))]
    pairs = {(position[a], position[b]) for a, b in splits if a in position and b in position}
    return pairs.pop() if len(pairs) == 1 else None


def _vector(file: Path) -> np.ndarray:
    """(m,) the whole numbers of the only vector in a .mat file."""
    with reading(file):
        try:
            content = loadmat(file)
        except (NotImplementedError, ValueError, TypeError) as error:
            raise InputError(f"{file}: expected a .mat file up to version 7: {error}") from error
    arrays = {name: np.asarray(value) for name, value in content.items() if not name.startswith("__")}
    vectors = {name: a.ravel() for name, a in arrays.items() if a.dtype.kind in "iuf" and a.size == max(a.shape) > 1}
    if len(vectors) != 1:
        raise InputError(f"{file}: expected one vector of vertices, got {', '.join(arrays) or 'nothing'}")
    (found,) = vectors.values()
    if not (found == np.round(found)).all():
        raise InputError(f"{file}: expected whole numbers")
    return found.astype(np.int64)
