"""A shape as a person has it at hand: a mesh of ours or of trimesh, arrays, a file. What every entry takes."""

import logging
import os
from collections.abc import Mapping
from hashlib import blake2b
from pathlib import Path
from typing import Any, TypeAlias, TypeGuard

import numpy as np
import trimesh
from numpy.typing import ArrayLike

from lssd_learn.errors import InputError, some_of
from lssd_learn.shapes.clean import clean, unmended
from lssd_learn.shapes.files import load
from lssd_learn.shapes.mesh import Mesh, PointCloud, Shape

log = logging.getLogger(__name__)

# A path, (vertices, faces), or points alone.
Given: TypeAlias = Shape | trimesh.Trimesh | trimesh.PointCloud | str | os.PathLike | tuple | ArrayLike

EXPECTED = "a Mesh, a PointCloud, a trimesh object, (vertices, faces), points (V, 3) or a path"


def as_shape(given: Given, name: str = "shape") -> Shape:
    """`given` as a mesh or a cloud.

    Args:
        given: a shape of ours, which comes back as it is; a Trimesh or PointCloud of trimesh; a pair (vertices (V, 3),
            faces (F, 3)); points (V, 3), a cloud; or the path of a file, which is cleaned as one of a folder is (see
            `clean`), and the log says what was done.
        name: what an error calls it.

    Raises:
        InputError: something else, a file that cannot be read, arrays that make no shape.
    """
    if isinstance(given, Mesh | PointCloud):
        return given
    if isinstance(given, str | os.PathLike):
        return _read(Path(given).expanduser())
    try:
        if isinstance(given, trimesh.Trimesh):
            return Mesh(given.vertices, given.faces)
        if isinstance(given, trimesh.PointCloud):
            return PointCloud(given.vertices)
        if is_pair(given):
            return Mesh(*given)
        if _is_points(given):
            return PointCloud(given)
    except InputError as error:
        raise InputError(f"{name}: {error}") from None
    raise InputError(f"{name}: expected {EXPECTED}, got {described(given)}")


def warn_of_unmended(shapes: Mapping[str, Shape]) -> None:
    """Say of shapes that came from no file, by their names, what is taken as it is and hardly ever meant."""
    found = {name: unmended(shape) for name, shape in shapes.items() if isinstance(shape, Mesh)}
    names = [name for name, faults in found.items() if faults]
    if names:
        several = f"{len(names):,} of {len(shapes):,} shapes ({some_of(names)}), the first"
        which = several if len(names) > 1 else names[0]
        log.warning("%s: %s: taken as it is; clean(mesh).mesh is mended", which, found[names[0]])


def content_key(shape: Shape) -> str:
    """32 hexadecimal digits that change whenever a vertex or a face does, or what the shape corresponds to."""
    content = blake2b(np.ascontiguousarray(shape.vertices).tobytes(), digest_size=16)
    if isinstance(shape, Mesh):
        content.update(shape.faces.tobytes())
    content.update(f"{type(shape).__name__} {len(shape.vertices)} {shape.connectivity}".encode())
    return content.hexdigest()


def is_one(given: Any) -> bool:
    """Whether this is one shape where several are expected: one of those `as_shape` takes that are no sequence, points
    (V, 3), or a pair of vertices and whole numbers."""
    one = isinstance(given, Mesh | PointCloud | trimesh.Trimesh | trimesh.PointCloud)
    return one or (isinstance(given, tuple) and is_pair(given)) or (hasattr(given, "shape") and _is_points(given))


def is_pair(given: Any) -> TypeGuard[tuple[Any, Any]]:
    """Whether this is (vertices, faces): two tables, of which the second holds whole numbers."""
    return (
        isinstance(given, tuple | list)
        and len(given) == 2
        and all(hasattr(table, "__len__") and not isinstance(table, str) for table in given)
        and _is_points(given[0])
        and _is_points(given[1], "iu")
    )


def described(given: Any) -> str:
    """What an object is, in a few words."""
    size = getattr(given, "shape", None)
    return f"{type(given).__name__}" if size is None else f"{type(given).__name__} of shape {tuple(size)}"


def _is_points(given: Any, kinds: str = "iuf") -> TypeGuard[Any]:
    try:
        array = np.asarray(given)
    except (ValueError, TypeError):
        return False
    return array.ndim == 2 and array.shape[1] == 3 and array.dtype.kind in kinds


def _read(path: Path) -> Shape:
    shape = load(path)
    if isinstance(shape, PointCloud):
        return shape
    cleaned = clean(shape, str(path))
    if cleaned.repairs:
        log.info("%s: %s", path.name, ", ".join(cleaned.repairs))
    return cleaned.mesh
