"""The two kinds of shape, a triangle mesh and a point cloud: what every later stage starts from."""

from dataclasses import dataclass
from functools import cached_property
from hashlib import blake2b
from typing import TypeAlias

import numpy as np
from jaxtyping import Float, Int

from lssd_learn.errors import InputError
from lssd_learn.shapes.triangles import triangle_normals


@dataclass(frozen=True, eq=False)
class Mesh:
    """A triangle mesh. Its arrays are checked when it is made and are read-only from then on.

    Attributes:
        vertices: (V, 3) float64, in the units of the file it came from.
        faces: (F, 3) int64, each row the three vertices of a triangle.
        pieces: how many connected pieces are meant to be in it; an eigenbasis of more is refused.

    Raises:
        InputError: an array of another shape, a coordinate that is not finite, a face that names a vertex that is
            not there, no face at all.

    Examples:
        >>> import lssd_learn as lssd
        >>> triangle = lssd.Mesh([[0, 0, 0], [2, 0, 0], [0, 1, 0]], [[0, 1, 2]])
        >>> float(triangle.area)
        1.0
    """

    vertices: Float[np.ndarray, "V 3"]
    faces: Int[np.ndarray, "F 3"]
    pieces: int = 1

    def __post_init__(self):
        # Frozen: the checked copies can only enter by this door.
        object.__setattr__(self, "vertices", _points(self.vertices, "vertices"))
        object.__setattr__(self, "faces", _faces(self.faces, len(self.vertices)))

    def __repr__(self) -> str:
        return f"{type(self).__name__}({len(self.vertices):,} vertices, {len(self.faces):,} faces)"

    @property
    def points(self) -> Float[np.ndarray, "V 3"]:
        """(V, 3) the vertices, by the name a cloud has for them."""
        return self.vertices

    @cached_property
    def connectivity(self) -> str:
        """A hash of vertex count and faces: equal for two meshes whose vertices correspond one to one."""
        content = blake2b(np.int64(len(self.vertices)).tobytes(), digest_size=16)
        content.update(self.faces.tobytes())
        return content.hexdigest()

    @cached_property
    def face_areas(self) -> Float[np.ndarray, " F"]:
        """(F,) the area of each triangle, in square units of length."""
        areas = np.linalg.norm(triangle_normals(self.vertices[self.faces]), axis=1) / 2
        areas.flags.writeable = False
        return areas

    @property
    def vertex_areas(self) -> Float[np.ndarray, " V"]:
        """(V,) a third of the area of the triangles around each vertex."""
        return np.bincount(self.faces.ravel(), np.repeat(self.face_areas / 3, 3), minlength=len(self.vertices))

    @property
    def area(self) -> float:
        """The sum of `face_areas`."""
        return float(self.face_areas.sum())


@dataclass(frozen=True, eq=False)
class PointCloud:
    """A point cloud, checked and read-only as a mesh is.

    Attributes:
        points: (V, 3) float64.

    Raises:
        InputError: an array of another shape, a coordinate that is not finite, no point at all.

    Examples:
        >>> import numpy as np
        >>> import lssd_learn as lssd
        >>> lssd.PointCloud(np.eye(3)).vertices.shape
        (3, 3)
    """

    points: Float[np.ndarray, "V 3"]

    def __post_init__(self):
        object.__setattr__(self, "points", _points(self.points, "points"))

    def __repr__(self) -> str:
        return f"PointCloud({len(self.points):,} points)"

    @property
    def vertices(self) -> Float[np.ndarray, "V 3"]:
        """(V, 3) the points, by the name a mesh has for them."""
        return self.points

    @property
    def connectivity(self) -> None:
        """None: a cloud has no faces that could say which points correspond."""
        return None


Shape: TypeAlias = Mesh | PointCloud

LARGEST = 1e70  # the fourth power of a coordinate, which an area takes, is still a number


def _points(points, name: str) -> np.ndarray:
    array = _numbers(points, name)
    if array.ndim != 2 or array.shape[1] != 3 or len(array) == 0:
        raise InputError(f"{name}: expected an array of shape (V, 3) with V ≥ 1, got {array.shape}")
    array = _frozen(array, np.float64)
    bad = ~(np.abs(array) < LARGEST).all(axis=1)
    if bad.any():
        first, values = bad.argmax(), " ".join(f"{x:g}" for x in array[bad.argmax()])
        raise InputError(
            f"{name}: expected finite coordinates, {bad.sum():,} of {len(array):,} are not, number {first} is {values}"
        )
    return array


def _faces(faces, n_vertices: int) -> np.ndarray:
    array = _numbers(faces, "faces")
    if array.ndim != 2 or array.shape[1] != 3 or len(array) == 0:
        raise InputError(f"faces: expected an array of shape (F, 3) with F ≥ 1, got {array.shape}")
    if array.dtype.kind == "f" and not (array == np.round(array)).all():
        raise InputError("faces: expected vertex indices, got numbers that are not whole")
    array = _frozen(array, np.int64)
    if array.min() < 0 or array.max() >= n_vertices:
        raise InputError(
            f"faces: expected indices from 0 to {n_vertices - 1}, got some from {array.min()} to {array.max()}"
        )
    return array


def _numbers(values, name: str) -> np.ndarray:
    try:
        array = np.asarray(values)
    except ValueError:  # rows of different lengths
        raise InputError(f"{name}: expected an array of rows of three numbers, got rows of different lengths") from None
    if array.dtype.kind not in "iuf":
        raise InputError(f"{name}: expected numbers, got {array.dtype}")
    return array


def _frozen(array: np.ndarray, dtype: type) -> np.ndarray:
    """`array` itself if nobody can write to it, so that many meshes share their faces; else a copy of that sort."""
    if array.flags.writeable or array.dtype != dtype or not array.flags.c_contiguous:
        array = np.array(array, dtype=dtype, order="C")
        array.flags.writeable = False
    return array
