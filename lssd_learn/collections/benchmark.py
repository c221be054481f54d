"""A public benchmark of correspondences, as it is distributed: a folder of meshes and which of their points are one.

FAUST, SCAPE, SMAL, TOPKIDS and SHREC'19 in the remeshed versions that papers report on are laid out as
`reading/truth.py` says. Nothing of them comes with this package.
"""

from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from hashlib import blake2b
from pathlib import Path

import numpy as np

from lssd_learn.cache import fingerprint
from lssd_learn.collections.base import Collection
from lssd_learn.collections.folder import Folder
from lssd_learn.collections.reading.truth import find_truth
from lssd_learn.collections.turned import check_turned, turned_shape
from lssd_learn.errors import InputError, check_whole, reading
from lssd_learn.kdtree import cKDTree
from lssd_learn.shapes import Shape

SHAPES = ("off", "shapes", "shapes_off", "meshes", "ply")  # folders, where the meshes are not in the folder itself


class Benchmark(Collection):
    """The meshes of a benchmark, in the order of their names; no two of one connectivity, whatever their faces.

    Args:
        path: its folder.
        first, last: of the shapes only those from number `first` on and before `last`, counted from 0, such as 80 and
            100, the test shapes of FAUST; None is all.
        turned: how each shape lies: "none", "vertical" or "any", see `turned_shape`.
        seed: of the turns.

    Attributes:
        vertex_maps: (a, b) → of the pairs that are known, for each vertex of b the vertex of a that the benchmark gives
            the nearest point of b that it knows anything of.

    Raises:
        InputError: no such folder, no shapes or no correspondences in it, an argument out of its range; when they are
            asked for, correspondences that do not fit their shapes.
    """

    truth = True

    def __init__(
        self,
        path: str | Path,
        first: int = 0,
        last: int | None = None,
        turned: str = "none",
        seed: int = 0,
    ):
        check_turned(turned)
        check_whole("collection.seed", seed, 0)
        self.path = Path(str(path)).expanduser()
        inside = [self.path / name for name in SHAPES if (self.path / name).is_dir()]
        self._folder = Folder(inside[0] if inside else self.path, "none")
        every = list(self._folder.names)
        check_whole("collection.first", first, 0, len(every) - 1)
        if last is not None:
            check_whole("collection.last", last, first + 1, len(every))
        self._truth = find_truth(self.path, self._folder.path, every)
        self._numbers = list(range(len(every)))[first:last]
        self.names = [every[n] for n in self._numbers]
        self.turned, self.seed = turned, int(seed)
        self._new_indices: dict[int, np.ndarray] = {}
        self.vertex_maps = _TrueMaps(self)

    def __len__(self) -> int:
        return len(self._numbers)

    def __getitem__(self, i: int) -> Shape:
        return turned_shape(self._folder[self._numbers[i]], self.turned, self.seed, self._numbers[i])

    def check(self) -> Sequence[str]:
        """The shapes too, and every correspondence."""
        warnings = self._folder.check()
        several = len(self.pairs) > len(self._truth.files)  # each file is in many pairs, and those with shape 0 do
        for pair in self.pairs:
            if pair[0] == 0 or not several:
                self.known(*pair)
        return warnings

    def remind(self, warnings) -> None:
        self._folder.remind(warnings)

    @cached_property
    def pairs(self) -> list[tuple[int, int]]:
        """(source, target) of those whose correspondence is known, as the benchmark has them."""
        place = {number: i for i, number in enumerate(self._numbers)}
        return [(place[a], place[b]) for a, b in self._truth.pairs if a in place and b in place]

    def known(self, i: int, j: int) -> tuple[np.ndarray, np.ndarray]:
        """(m,) vertices of shape i and (m,) vertices of shape j that are the same points; one of `pairs`."""
        ours, theirs = self._new_index(i), self._new_index(j)
        here, there = self._truth.known(self._numbers[i], self._numbers[j], (len(ours), len(theirs)))
        here, there = ours[here], theirs[there]
        kept = (here >= 0) & (there >= 0)
        if not kept.any():
            raise InputError(f"{self.path}: nothing is left of what {self.names[i]} and {self.names[j]} have in common")
        return here[kept], there[kept]

    def _new_index(self, i: int) -> np.ndarray:
        """(V,) for each vertex in the file of shape i its vertex, -1 where it was dropped."""
        if i not in self._new_indices:
            self._new_indices[i] = self._folder.read(self._numbers[i]).new_index
        return self._new_indices[i]

    @cached_property
    def key(self) -> str:
        """Depends on the bytes and names of all files, and on the arguments."""
        beside = []
        for shapes, file in self._truth.files.items():
            with reading(file):
                beside.append((list(shapes), blake2b(file.read_bytes(), digest_size=16).hexdigest()))
        return fingerprint("Benchmark", [self.shape_key(i) for i in range(len(self))], self.names, beside)

    def shape_key(self, i: int) -> str:
        """Depends on the bytes of one file, and on how the shape is turned."""
        key = self._folder.shape_key(self._numbers[i])
        return key if self.turned == "none" else fingerprint("turned", key, self.turned, self.seed, self._numbers[i])


class _TrueMaps(Mapping):
    """(a, b) → for each vertex of b the vertex of a; made when asked for."""

    def __init__(self, collection: Benchmark):
        self._collection = collection

    def __len__(self) -> int:
        return len(self._collection.pairs)

    def __iter__(self) -> Iterator[tuple[int, int]]:
        return iter(self._collection.pairs)

    def __getitem__(self, pair: tuple[int, int]) -> np.ndarray:
        if pair not in self._collection.pairs:
            raise KeyError(pair)
        here, there = self._collection.known(*pair)
        points = self._collection[pair[1]].vertices
        return here[cKDTree(points[there]).query(points)[1]]
