"""What is known of each shape as columns by name: its parameters, groups and covariates, and its size as it lies there.

What a formula may speak of, see `exploration.models.design`.
"""

from collections.abc import Iterable

import numpy as np

from lssd_learn.collections.base import Collection
from lssd_learn.collections.groups import UNKNOWN
from lssd_learn.errors import InputError
from lssd_learn.progress import track
from lssd_learn.shapes import Mesh, Shape
from lssd_learn.shapes.triangles import enclosed

# Of every shape, unless a column of the collection has the name.
MEASURED = ("area", "size", "volume")


def columns(collection: Collection, names: Iterable[str]) -> dict[str, np.ndarray]:
    """Some columns: numbers (n,) float64, nan where unknown, and labels (n,) of objects, None where unknown.

    Beside parameters and groups there are, in the units of the shapes: `area`; `size`, the centroid size, which is the
    root of the mean square distance of the surface from its centroid; `volume`, that a closed mesh encloses.

    Args:
        collection: n shapes.
        names: of the columns.

    Raises:
        InputError: no such column, an area of a cloud, a volume of a mesh that is not closed.
    """
    names = list(dict.fromkeys(names))
    known = available(collection)
    for name in names:
        if name not in known:
            why = collection.lacks("groups", name)
            raise InputError(f"no column {name!r}: expected some of {', '.join(known)}; {why}")
    found: dict[str, np.ndarray] = {}
    parameters = list(collection.parameter_names)
    for name in names:
        if name in collection.groups:
            labels = [str(label) for label in collection.groups[name]]
            found[name] = np.array([None if label in UNKNOWN else label for label in labels], dtype=object)
        elif name in collection.covariates:
            found[name] = np.asarray(collection.covariates[name], dtype=float)
        elif name in parameters and collection.parameters is not None:
            found[name] = np.asarray(collection.parameters, dtype=float)[:, parameters.index(name)]
    if measured := [name for name in names if name not in found]:
        found |= _measured(collection, measured)
    return {name: found[name] for name in names}


def available(collection: Collection) -> list[str]:
    """The names of all columns."""
    parameters = [] if collection.parameters is None else list(collection.parameter_names)
    return list(dict.fromkeys([*collection.groups, *parameters, *collection.covariates, *MEASURED]))


def centroid_size(shape: Shape) -> float:
    """√(∫‖x − c‖² / ∫1) over the surface, c its centroid; over the points of a cloud. Exact for flat triangles."""
    if not isinstance(shape, Mesh):
        return float(np.sqrt(np.square(shape.points - shape.points.mean(0)).sum(1).mean()))
    corners, weights = shape.vertices[shape.faces], shape.face_areas / shape.area
    middles = corners.mean(1)
    away = corners - weights @ middles
    # ∫‖x‖² over a triangle of area A: A/12 (‖a‖² + ‖b‖² + ‖c‖² + ‖a + b + c‖²)
    squares = (np.square(away).sum((1, 2)) + np.square(away.sum(1)).sum(1)) / 12
    return float(np.sqrt(weights @ squares))


def enclosed_volume(mesh: Mesh) -> float:
    """What a closed mesh encloses, by the divergence theorem, whichever way its faces are turned.

    Raises:
        InputError: an edge that is not one of two triangles, which run along it in opposite directions.
    """
    edges = np.concatenate([mesh.faces[:, [a, b]] for a, b in ((0, 1), (1, 2), (2, 0))])
    forth, back = (np.unique(some, axis=0) for some in (edges, edges[:, ::-1]))
    if len(forth) < len(edges) or not np.array_equal(forth, back):
        raise InputError("expected a closed mesh, whose every edge is one of two triangles")
    return enclosed(mesh.vertices[mesh.faces] - mesh.vertices.mean(0))


def _measured(collection: Collection, names: list[str]) -> dict[str, np.ndarray]:
    found = {name: np.empty(len(collection)) for name in names}
    for i in track(range(len(collection)), f"measuring {', '.join(names)}"):
        shape = collection[i]
        for name in names:
            found[name][i] = _measure(name, shape, collection.names[i])
    return found


def _measure(name: str, shape: Shape, whose: str) -> float:
    if name == "size":
        return centroid_size(shape)
    if not isinstance(shape, Mesh):
        raise InputError(f"{name} of {whose}: expected a mesh, got a point cloud; size is known of clouds too")
    if name == "area":
        return shape.area
    try:
        return enclosed_volume(shape)
    except InputError as error:
        raise InputError(f"volume of {whose}: {error}") from None
