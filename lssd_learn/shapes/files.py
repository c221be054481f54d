"""Reading and writing shapes: OFF, OBJ, PLY, STL, GLB, XYZ. Coordinates are neither rotated nor scaled.

Vertices keep the order of the file in every format but STL, which has none: there, equal corners become one vertex.
OFF, OBJ and XYZ are written with every digit; PLY, STL and GLB hold float32.
"""

import io
import logging
import os
import re
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from uuid import uuid4

import numpy as np
import trimesh

from lssd_learn.errors import InputError, reading
from lssd_learn.shapes.mesh import Mesh, PointCloud, Shape
from lssd_learn.shapes.text import read_obj, read_xyz, write_obj, write_off, write_xyz

FORMATS = (".off", ".obj", ".ply", ".stl", ".glb", ".xyz")
_TEXT_WRITERS = {".off": write_off, ".obj": write_obj, ".xyz": write_xyz}


def load(path: str | Path) -> Shape:
    """Read one shape: a `Mesh` if the file has faces, otherwise a `PointCloud`. Polygons are cut into triangles.

    Raises:
        InputError: no such file, another format, a damaged, truncated or empty file, coordinates that are not finite.
    """
    path = Path(path)
    suffix = _suffix(path)
    if not path.is_file():
        raise InputError(f"{path}: no such file")
    with reading(path):
        data = path.read_bytes()
    if not data.strip():
        raise InputError(f"{path}: expected a shape, the file is empty")
    try:
        with _quiet():
            vertices, faces = _parse(data, suffix)
    except Exception as error:  # parsers fail in any way they like on a damaged file
        reason = str(error).strip().splitlines() or [type(error).__name__]
        kind = suffix[1:].upper()
        raise InputError(f"{path}: expected {kind}, it is damaged, cut off or something else: {reason[0]}") from error
    if len(vertices) == 0:
        raise InputError(f"{path}: expected a mesh or a point cloud, found no vertices")
    try:
        return Mesh(vertices, faces) if len(faces) else PointCloud(vertices)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None


def save(shape: Shape, path: str | Path) -> None:
    """Write `shape` in the format of the suffix; the file appears complete or not at all.

    Raises:
        InputError: an unknown suffix, a folder that is not there, a cloud as STL (which has only faces), a mesh as
            XYZ (which has none).
    """
    path = Path(path)
    suffix = _suffix(path)
    if isinstance(shape, PointCloud) and suffix == ".stl":
        raise InputError(f"{path}: STL holds faces only, a point cloud needs one of .ply .glb .obj .off .xyz")
    if isinstance(shape, Mesh) and suffix == ".xyz":
        raise InputError(f"{path}: XYZ holds points only, a mesh needs one of .off .obj .ply .stl .glb")
    if not path.parent.is_dir():
        raise InputError(f"{path}: the folder {path.parent} does not exist")
    data = _TEXT_WRITERS[suffix](shape).encode() if suffix in _TEXT_WRITERS else _binary(shape, suffix)
    temporary = path.with_name(f".{path.name}.{uuid4().hex}")
    try:
        temporary.write_bytes(data)
        os.replace(temporary, path)
    finally:
        temporary.unlink(missing_ok=True)


@contextmanager
def _quiet() -> Iterator[None]:
    """Without what parsers say about a damaged file on their way: warnings, and tracebacks in trimesh's log."""
    log = logging.getLogger("trimesh")
    level = log.level
    log.setLevel(logging.CRITICAL)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    finally:
        log.setLevel(level)


def _suffix(path: Path) -> str:
    suffix = path.suffix.lower()
    if suffix not in FORMATS:
        raise InputError(f"{path}: expected one of {' '.join(FORMATS)}, got {suffix or 'no suffix'!r}")
    return suffix


def _parse(data: bytes, suffix: str) -> tuple[np.ndarray, np.ndarray]:
    """Vertices and faces, unchecked."""
    if suffix == ".obj":
        return read_obj(data.decode("utf-8", errors="replace"))
    if suffix == ".xyz":
        return read_xyz(data.decode("utf-8", errors="replace")), np.empty((0, 3))
    if suffix == ".stl":
        _check_length(data)
    options = {"fix_texture": False} if suffix == ".ply" else {}  # it would duplicate vertices along seams
    if suffix in (".ply", ".glb"):
        options["skip_materials"] = True
    loaded = trimesh.load(io.BytesIO(data), file_type=suffix[1:], process=False, **options)
    vertices, faces = _geometry(loaded)
    if suffix == ".stl":
        vertices, faces = _merge_corners(vertices, faces)
    n_vertices, n_faces = _declared(data, suffix)
    if len(vertices) < n_vertices or len(faces) < n_faces:
        raise ValueError(
            f"it announces {n_vertices:,} vertices and {n_faces:,} faces, "
            f"{len(vertices):,} and {len(faces):,} are there"
        )
    return vertices, faces


def _geometry(loaded) -> tuple[np.ndarray, np.ndarray]:
    """Everything in what trimesh returned, as one: meshes if there are any, otherwise points."""
    parts = loaded.dump() if isinstance(loaded, trimesh.Scene) else [loaded]  # a scene's parts, placed by its nodes
    meshes = [part for part in parts if isinstance(part, trimesh.Trimesh) and len(part.faces)]
    kept = meshes or [part for part in parts if isinstance(part, trimesh.PointCloud | trimesh.Trimesh)]
    starts = np.cumsum([0] + [len(part.vertices) for part in kept])
    vertices = [np.empty((0, 3)), *(part.vertices for part in kept)]
    faces = [np.empty((0, 3), np.int64), *(m.faces + start for m, start in zip(meshes, starts, strict=False))]
    return np.concatenate(vertices), np.concatenate(faces)


def _merge_corners(vertices: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """One vertex for all corners at exactly the same place, in the order of first appearance."""
    _, first, inverse = np.unique(vertices + 0.0, axis=0, return_index=True, return_inverse=True)  # -0 becomes 0
    order = np.argsort(first)
    return vertices[first[order]], np.argsort(order)[inverse.ravel()][faces]


def _check_length(data: bytes) -> None:
    """Refuse a binary STL that is cut off: trimesh would look for text in it, and find no shape."""
    count = int.from_bytes(data[80:84], "little")
    if b"\0" in data[:84] and (len(data) < 84 or len(data) < 84 + 50 * count):
        raise ValueError(f"it announces {count:,} faces, {max(0, len(data) - 84) // 50:,} are there")


def _declared(data: bytes, suffix: str) -> tuple[int, int]:
    """Vertex and face count in the header of an OFF or PLY: trimesh takes what is left of a truncated text file."""
    if suffix == ".off":
        counts = re.search(rb"OFF(?:\s|#[^\n]*\n)+(\d+)\s+(\d+)", data)
        return (int(counts[1]), int(counts[2])) if counts else (0, 0)
    if suffix == ".ply":
        head = data.split(b"end_header", 1)[0]
        counts = [re.search(rb"element\s+" + kind + rb"\s+(\d+)", head) for kind in (b"vertex", b"face")]
        return tuple(int(count[1]) if count else 0 for count in counts)
    return 0, 0


def _binary(shape: Shape, suffix: str) -> bytes:
    if isinstance(shape, PointCloud):
        exported = trimesh.PointCloud(shape.points)
    else:
        exported = trimesh.Trimesh(shape.vertices, shape.faces, process=False)
    if suffix == ".glb":
        exported = trimesh.Scene(exported)
    return exported.export(file_type=suffix[1:])
