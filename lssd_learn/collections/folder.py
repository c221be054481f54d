"""A folder of one's own shapes as a collection: the meshes and clouds in it, and the tables and maps beside them.

Files are listed and the tables checked at once; each shape is read, and cleaned, when it is asked for. Landmarks and
maps come re-indexed to the cleaned shapes. What is read how stands in `reading/`, file formats and cleaning in
`lssd_learn.shapes`.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from hashlib import blake2b, file_digest
from operator import index
from pathlib import Path
from typing import cast

import numpy as np

from lssd_learn.cache import Cache
from lssd_learn.collections.base import Collection
from lssd_learn.collections.reading.alike import SameFaces
from lssd_learn.collections.reading.labels import Labels, read_labels
from lssd_learn.collections.reading.landmark_sources import find_landmarks, read_source
from lssd_learn.collections.reading.landmarks import Landmarks
from lssd_learn.collections.reading.listing import check_file, map_files, shape_files, unread_shapes, unread_tables
from lssd_learn.collections.reading.maps import VertexMaps
from lssd_learn.collections.reading.mask import MASK_VERSION, Masks
from lssd_learn.collections.reading.names import Names, composed
from lssd_learn.collections.reading.pieces import PIECES, KeptPieces
from lssd_learn.collections.reading.shape import ReadShape, read_shape
from lssd_learn.collections.reading.sizes import odd_sizes, size
from lssd_learn.collections.reading.table import find_table
from lssd_learn.collections.reading.told import Told
from lssd_learn.errors import InputError, reading
from lssd_learn.progress import track
from lssd_learn.shapes import FORMATS, Mesh, PointCloud, Shape

# Goes up whenever the same files give other shapes.
READER_VERSION = 3


@dataclass(frozen=True, eq=False, repr=False)
class UnrelatedMesh(Mesh):
    """A mesh that is in vertex correspondence with no other, whatever its faces."""

    @property
    def connectivity(self) -> None:
        return None


class Folder(Collection):
    """Every mesh and cloud file of a folder, in the order of the sorted names.

    Beside them, each optional: `labels.csv` (or .tsv; see `reading/labels.py`), `landmarks.csv` (or .tsv, or files of
    other programs; see `reading/landmark_table.py` and `reading/landmark_sources.py`) and `maps/A__B.txt`, which holds
    for each vertex of B the vertex of A, counted from 0.

    Args:
        path: the folder.
        correspondence: "auto": shapes with the same faces are taken to be in vertex correspondence, which the log
            tells; "none": no two are.
        groups: numeric columns of `labels.csv` that are groups, not parameters.
        parameters: columns of `labels.csv` that are targets; None is all of numbers but those that identify the shapes
            and those that are the same for all.
        covariates: columns of `labels.csv` that are no targets; of some shapes they may be unknown.
        pieces: of a mesh in several connected pieces, "largest", "all", "left" or "right", by the mean x; None is the
            largest, where it is clear which that is and most of the area is in it. See `reading/pieces.py`.
        normalise_area: scale every mesh, about the origin, to unit area.
        mask: "outer", "vertices" or "painted", the part of every mesh that is looked at; the rest is cut away. None is
            all of it. See `reading/mask.py`.
        up: "z" or "y", which axis points up; for display only.

    Raises:
        InputError: no such folder, no shape in it, two of one name, a table that does not fit, an argument out of its
            range. On access: a file that cannot be read, a landmark or map that does not fit its shapes.
    """

    landmarks: Landmarks | tuple[()] = ()
    vertex_maps: VertexMaps

    def __init__(
        self,
        path: str | Path,
        correspondence: str = "auto",
        groups: Sequence[str] = (),
        parameters: Sequence[str] | None = None,
        pieces: str | None = None,
        normalise_area: bool = False,
        up: str | None = None,
        covariates: Sequence[str] = (),
        mask: str | None = None,
    ):
        if correspondence not in ("auto", "none"):
            raise InputError(f"correspondence: expected auto or none, got {correspondence!r}")
        if pieces not in PIECES:
            raise InputError(f"pieces: expected {', '.join(map(str, PIECES[1:]))} or null, got {pieces!r}")
        if up not in (None, "y", "z"):
            raise InputError(f"up: expected y or z, got {up!r}")
        for name, columns in (("groups", groups), ("parameters", parameters), ("covariates", covariates)):
            if isinstance(columns, str):
                raise InputError(f"{name}: expected a list of columns of labels.csv, got {columns!r}")
        self.path = Path(str(path)).expanduser()  # 2024 is a name too
        self.correspondence, self.normalise_area, self.up = correspondence, bool(normalise_area), up
        self.pieces = pieces
        self.files = shape_files(self.path)
        self.names = [composed(file.stem) for file in self.files]
        names = Names(self.names, [file.name for file in self.files])
        self._masks = Masks(mask, self.path, self.names)
        self._told, self._checked = Told(), False
        self._connectivities: list[str | None] = []
        self._groups = tuple(composed(str(column)) for column in groups)
        self._covariates = tuple(composed(str(column)) for column in covariates)
        self._parameters = None if parameters is None else tuple(composed(str(column)) for column in parameters)

        labels, landmarks = find_table(self.path, "labels"), find_landmarks(self.path, names, self._told)
        self._tables = [*([] if labels is None else [labels]), *([] if landmarks is None else landmarks.files)]
        self._labels: Labels | None = None
        if labels is not None:
            check_file(labels)
            self._labels = table = read_labels(labels, names, self._groups, self._parameters, self._covariates)
            self.parameters, self.parameter_names, self.groups = table.parameters, table.parameter_names, table.groups
            self.covariates = table.covariates
        elif wanted := [*groups, *(parameters or ()), *covariates]:
            to = "to group by" if groups else "for a target" if parameters else "for a covariate"
            raise InputError(
                f"{self.path / 'labels.csv'}: expected this file with a column {wanted[0]!r} {to}, it is not there"
            )
        if landmarks is not None:
            for file in landmarks.files:
                check_file(file)
            read = read_source(landmarks, names, self._told)
            self.landmarks = Landmarks(landmarks.path, read, self.names, self.read, self._told)
        self.vertex_maps = VertexMaps(map_files(self.path, self.names), self.read, self._told)
        for message in unread_tables(self.path, self._tables, has_landmarks=landmarks is not None):
            self._told.warn(message)
        if others := unread_shapes(self.path):
            self._told.warn(f"{self.path.name}: not read: {others} (shapes are {' '.join(FORMATS)})")

    def __len__(self) -> int:
        return len(self.files)

    def __getitem__(self, i: int) -> Shape:
        i = range(len(self))[index(i)]  # IndexError past the end, negative counts from it
        return self._finished(self.read(i))

    def check(self) -> list[str]:
        if self._checked:
            return self._told.warnings
        same, kept = SameFaces(self.names, self._told), KeptPieces(self.names, self._told)
        sizes, kinds = [], []
        for i in track(range(len(self)), f"reading {self.path.name}"):
            read = self.read(i)
            shape = self._finished(read)
            sizes.append(size(shape))
            kinds.append(shape.connectivity)
            if isinstance(shape, Mesh) and shape.connectivity is not None:
                same.add(i, shape)
                if isinstance(read.original, Mesh) and self.pieces not in ("left", "right"):
                    kept.add(i, read.original, read.vertex_index)
            if self.landmarks:
                self.landmarks[i]
        same.tell()
        kept.tell(masked=bool(self._masks))
        if not self.normalise_area:
            for line in odd_sizes(self.names, sizes):
                self._told.warn(f"{self.path.name}: {line}")
        if self.landmarks:
            self.landmarks.check()
        for pair in self.vertex_maps:
            self.vertex_maps[pair]
        self._connectivities, self._checked = kinds, True
        return self._told.warnings

    def keep_in(self, cache: Cache | None, workers: int | None = None) -> None:
        self._masks.cache = cache

    @property
    def connectivities(self) -> list[str | None]:
        if not self._checked:
            self.check()
        return self._connectivities

    def told(self) -> list[str]:
        return self._told.messages

    def remind(self, warnings: Iterable[str]) -> None:
        self._told.remind(warnings)

    def marked(self, i: int) -> Mapping[str, np.ndarray]:
        places = self.landmarks.place(i).places if self.landmarks else {}
        if not (self.normalise_area and places):
            return places
        size = np.sqrt(cast(Mesh, self.read(i).shape).area)
        return {name: point / size for name, point in places.items()}

    def lacks(self, what: str, name: str | None = None) -> str:
        if self._labels is None:
            return super().lacks(what, name)
        return self._labels.lacks(what, name)

    @cached_property
    def key(self) -> str:
        """Depends on the bytes and names of all files, and on the arguments."""
        tables = [*self._tables, *self.vertex_maps.files.values()]
        beside = [(str(file.relative_to(self.path)), _digest(file)) for file in tables]
        shapes = [(file.name, self.shape_key(i)) for i, file in enumerate(self.files)]
        more = [self._covariates] if self._covariates else []  # the key without is the one from before there were any
        return _hash("Folder", shapes, beside, self._groups, self._parameters, self.pieces, self.up, *more)

    def shape_key(self, i: int) -> str:
        """Depends on the bytes of one file and on the arguments that change its shape."""
        return self._shape_keys[i]

    def space(self, i: int) -> str:
        """As the file of the shape says; where it says none, as landmarks of the folder are in."""
        return self.read(i).space or (self.landmarks.space if self.landmarks else "")

    @cached_property
    def _shape_keys(self) -> list[str]:
        arguments = (READER_VERSION, self.correspondence, self.pieces or "largest", self.normalise_area)
        masks = [(self._masks.kind, MASK_VERSION, *map(_digest, self._masks.files[i : i + 1])) if self._masks else ()
                 for i in range(len(self))]  # fmt: skip
        return [
            _hash("Folder shape", file.suffix.lower(), _digest(file), *arguments, *mask)
            for file, mask in zip(self.files, masks, strict=True)
        ]

    def read(self, i: int) -> ReadShape:
        """Shape i as its file has it, and which vertex went where."""
        return read_shape(self.files[i], i, self.pieces, self._masks, self._told)

    def _finished(self, read: ReadShape) -> Shape:
        """What the folder gives of a shape that was read."""
        shape = read.shape
        if self.normalise_area:
            if isinstance(shape, PointCloud):
                raise InputError(f"{self.path / read.name}: expected a mesh (normalise_area is on), got a point cloud")
            shape = replace(shape, vertices=shape.vertices / np.sqrt(shape.area))
        if isinstance(shape, Mesh) and self.correspondence == "none":
            return UnrelatedMesh(shape.vertices, shape.faces, shape.pieces)
        return shape


def _digest(file: Path) -> str:
    with reading(file), file.open("rb") as stream:
        return file_digest(stream, lambda: blake2b(digest_size=16)).hexdigest()


def _hash(*parts) -> str:
    return blake2b(repr(parts).encode(), digest_size=16).hexdigest()
