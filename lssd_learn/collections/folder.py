"""A folder of one's own shapes as a collection: the meshes and clouds in it, and the tables and maps beside them.

Files are listed and the tables checked at once; each shape is read, and cleaned, when it is asked for. Landmarks and
maps come re-indexed to the cleaned shapes. File formats and cleaning are in `lssd_learn.shapes`.
"""

import logging
from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from hashlib import blake2b, file_digest
from operator import index
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

from lssd_learn.collections.base import Collection
from lssd_learn.collections.reading.listing import check_file, map_files, read_indices, shape_files
from lssd_learn.collections.reading.labels import read_labels
from lssd_learn.collections.reading.landmark_table import Landmark, read_landmarks
from lssd_learn.errors import InputError, reading
from lssd_learn.progress import track
from lssd_learn.shapes import Mesh, PointCloud, Shape, clean, load

log = logging.getLogger(__name__)

# Goes up whenever the same files give other shapes.
READER_VERSION = 1


@dataclass(frozen=True, eq=False)
class UnrelatedMesh(Mesh):
    """A mesh that is in vertex correspondence with no other, whatever its faces."""

    @property
    def connectivity(self) -> None:
        return None


class Folder(Collection):
    """Every mesh and cloud file of a folder, in the order of the sorted names.

    Beside them, each optional: `labels.csv`, `landmarks.csv` (see `tables.py`) and `maps/A__B.txt`, which holds for
    each vertex of B the vertex of A, counted from 0.

    Args:
        path: the folder.
        correspondence: "auto": shapes with the same faces are taken to be in vertex correspondence, which the log
            tells; "none": no two are.
        groups: numeric columns of `labels.csv` that are groups, not parameters.
        normalise_area: scale every mesh, about the origin, to unit area.
        up: "z" or "y", which axis points up; for display only.

    Raises:
        InputError: no such folder, no shape in it, two of one name, a table that does not fit, an argument out of its
            range. On access: a file that cannot be read, a landmark or map that does not fit its shapes.
    """

    def __init__(
        self,
        path: str | Path,
        correspondence: str = "auto",
        groups: Sequence[str] = (),
        normalise_area: bool = False,
        up: str | None = None,
    ):
        if correspondence not in ("auto", "none"):
            raise InputError(f"correspondence: expected auto or none, got {correspondence!r}")
        if up not in (None, "y", "z"):
            raise InputError(f"up: expected y or z, got {up!r}")
        if isinstance(groups, str):
            raise InputError(f"groups: expected a list of columns of labels.csv, got {groups!r}")
        self.path = Path(str(path)).expanduser()  # 2024 is a name too
        self.correspondence, self.normalise_area, self.up = correspondence, bool(normalise_area), up
        self.files = shape_files(self.path)
        self.names = [file.stem for file in self.files]
        self._asked_groups = tuple(groups)
        self._told: set[str] = set()
        self._told_correspondence = False
        self._checked = False
        self._first_with: dict[str, int] = {}  # connectivity → the first shape seen with it

        labels = self.path / "labels.csv"
        if labels.exists():
            check_file(labels)
            table = read_labels(labels, self.names, self._asked_groups)
            self.parameters, self.parameter_names, self.groups = table.parameters, table.parameter_names, table.groups
        elif groups:
            raise InputError(f"{labels}: expected this file with a column {groups[0]!r} to group by, it is not there")
        landmarks = self.path / "landmarks.csv"
        if landmarks.exists():
            check_file(landmarks)
            self.landmarks = _Landmarks(read_landmarks(landmarks, self.names), self._place)
        self.vertex_maps = _VertexMaps(map_files(self.path / "maps", self.names), self._read_map)

    def __len__(self) -> int:
        return len(self.files)

    def __getitem__(self, i: int) -> Shape:
        i = range(len(self))[index(i)]  # IndexError past the end, negative counts from it
        shape = self._read(i).shape
        if self.normalise_area:
            if isinstance(shape, PointCloud):
                raise InputError(f"{self.files[i]}: expected a mesh (normalise_area is on), got a point cloud")
            shape = Mesh(shape.vertices / np.sqrt(shape.area), shape.faces)
        if isinstance(shape, Mesh) and self.correspondence == "none":
            return UnrelatedMesh(shape.vertices, shape.faces)
        if isinstance(shape, Mesh):
            self._tell_correspondence(i, shape)
        return shape

    def check(self) -> None:
        if self._checked:
            return
        for i in track(range(len(self)), f"reading {self.path.name}"):
            self[i]
            if self.landmarks:
                self.landmarks[i]
        for pair in self.vertex_maps:
            self.vertex_maps[pair]
        self._checked = True

    @cached_property
    def key(self) -> str:
        """Depends on the bytes and names of all files, and on the arguments."""
        tables = [self.path / "labels.csv", self.path / "landmarks.csv", *self.vertex_maps.files.values()]
        beside = [(str(file.relative_to(self.path)), _digest(file)) for file in tables if file.is_file()]
        shapes = [(file.name, self.shape_key(i)) for i, file in enumerate(self.files)]
        return _hash("Folder", shapes, beside, self._asked_groups, self.up)

    def shape_key(self, i: int) -> str:
        """Depends on the bytes of one file and on the arguments that change its shape."""
        return self._shape_keys[i]

    @cached_property
    def _shape_keys(self) -> list[str]:
        arguments = (READER_VERSION, self.correspondence, self.normalise_area)
        return [_hash("Folder shape", file.suffix.lower(), _digest(file), *arguments) for file in self.files]

    def _read(self, i: int) -> "_Read":
        shape = load(self.files[i])
        if isinstance(shape, PointCloud):
            if self.files[i].suffix.lower() != ".xyz":
                self._tell(f"{self.files[i].name}: no faces in it, taken as a point cloud")
            return _Read(shape, shape.points, np.arange(len(shape.points)), np.arange(len(shape.points)))
        cleaned = clean(shape, str(self.files[i]))
        if cleaned.repairs:
            self._tell(f"{self.files[i].name}: {', '.join(cleaned.repairs)}")
        return _Read(cleaned.mesh, shape.vertices, cleaned.vertex_index, cleaned.new_index)

    def _tell(self, message: str, level: int = logging.INFO) -> None:
        """Log a message the first time: shapes are read again and again."""
        if message not in self._told:
            self._told.add(message)
            log.log(level, message)

    def _tell_correspondence(self, i: int, mesh: Mesh) -> None:
        first = self._first_with.setdefault(mesh.connectivity, i)
        if first != i and not self._told_correspondence:
            self._told_correspondence = True
            log.info(
                "%s and %s have the same faces: such shapes are taken to be in vertex correspondence "
                "(collection.correspondence=none forbids it)",
                self.names[first],
                self.names[i],
            )

    def _place(self, i: int, landmarks: Sequence[Landmark]) -> dict[str, int]:
        """Landmarks of shape i as vertices of the cleaned shape."""
        if not landmarks:
            return {}
        read = self._read(i)
        placed: dict[str, int] = {}
        for landmark in landmarks:
            vertex = landmark.vertex
            if vertex is None:
                self._check_near(i, landmark, read.original)
                vertex = int(np.argmin(((read.original - landmark.point) ** 2).sum(1)))
            if vertex >= len(read.original):
                raise InputError(
                    f"{landmark.where}: expected a vertex of {self.files[i].name}, 0 to {len(read.original) - 1}, "
                    f"got {vertex}"
                )
            placed[landmark.name] = int(read.new_index[vertex])
            if placed[landmark.name] < 0:
                raise InputError(
                    f"{landmark.where}: expected a vertex of the largest component of {self.files[i].name}, "
                    f"landmark {landmark.name!r} is at vertex {vertex} of another piece, which is dropped"
                )
        by_vertex = defaultdict(list)
        for name, vertex in placed.items():
            by_vertex[vertex].append(name)
        shared = [" and ".join(names) for names in by_vertex.values() if len(names) > 1]
        if shared:
            message = f"{self.names[i]}: landmarks at one vertex: {', '.join(shared)}"
            self._tell(message, logging.WARNING)
        return placed

    def _check_near(self, i: int, landmark: Landmark, points: np.ndarray) -> None:
        """Refuse a landmark nowhere near its shape: another unit of length, or another frame."""
        low, high = points.min(axis=0), points.max(axis=0)
        away = np.maximum(0, np.maximum(low - landmark.point, landmark.point - high)).max()
        if away > (high - low).max():
            raise InputError(
                f"{landmark.where}: expected landmark {landmark.name!r} near {self.files[i].name}, which is "
                f"{(high - low).max():.3g} across; it is {away:.3g} away from it"
            )

    def _read_map(self, file: Path, pair: tuple[int, int]) -> np.ndarray:
        """A map file re-indexed to the cleaned shapes; where it leads to a dropped piece, the nearest vertex kept."""
        source, target = (self._read(i) for i in pair)
        vertices = read_indices(file)
        a, b = (self.names[i] for i in pair)
        if len(vertices) != len(target.original):
            raise InputError(
                f"{file}: expected a vertex of {a} for each of the {len(target.original)} vertices of {b}, "
                f"got {len(vertices)}"
            )
        if vertices.min() < 0 or vertices.max() >= len(source.original):
            wrong = vertices.min() if vertices.min() < 0 else vertices.max()
            raise InputError(f"{file}: expected vertices of {a}, 0 to {len(source.original) - 1}, got {wrong}")
        vertices = vertices[target.vertex_index]
        mapped = source.new_index[vertices]
        lost = mapped < 0
        if lost.any():
            mapped[lost] = cKDTree(source.shape.points).query(source.original[vertices[lost]])[1]
            some = "1 vertex" if lost.sum() == 1 else f"{lost.sum():,} vertices"
            self._tell(f"{file.name}: {some} led to a dropped piece, now to the nearest vertex kept")
        return mapped


@dataclass(frozen=True, eq=False)
class _Read:
    """A cleaned shape, with the (V, 3) points it had before and the indices of `lssd_learn.shapes.Cleaned`."""

    shape: Shape
    original: np.ndarray
    vertex_index: np.ndarray
    new_index: np.ndarray


@dataclass(frozen=True, eq=False)
class _Landmarks(Sequence):
    """Landmarks of each shape, placed when asked for: only then is the shape read."""

    rows: list[list[Landmark]]
    place: Callable[[int, Sequence[Landmark]], dict[str, int]]

    def __len__(self) -> int:
        return len(self.rows)

    def __getitem__(self, i: int) -> dict[str, int]:
        i = range(len(self))[index(i)]
        return self.place(i, self.rows[i])


@dataclass(frozen=True, eq=False)
class _VertexMaps(Mapping):
    """(a, b) → the map of that file, read when asked for."""

    files: dict[tuple[int, int], Path]
    read: Callable[[Path, tuple[int, int]], np.ndarray]

    def __len__(self) -> int:
        return len(self.files)

    def __iter__(self) -> Iterator[tuple[int, int]]:
        return iter(self.files)

    def __getitem__(self, pair: tuple[int, int]) -> np.ndarray:
        return self.read(self.files[pair], pair)


def _digest(file: Path) -> str:
    with reading(file), file.open("rb") as stream:
        return file_digest(stream, lambda: blake2b(digest_size=16)).hexdigest()


def _hash(*parts) -> str:
    return blake2b(repr(parts).encode(), digest_size=16).hexdigest()
