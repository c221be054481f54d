"""A few shapes of a collection kept at hand, so that a run that only shows them loads no body model and no file."""

import numpy as np

from lssd_learn.cache import DEFAULT, Cache, fingerprint
from lssd_learn.collections.base import Collection
from lssd_learn.collections.given import as_collection
from lssd_learn.shapes import Mesh, PointCloud, Shape

STAGE = "previews"
VERSION = 1


def previews(collection: Collection, count: int, cache: Cache | None = DEFAULT) -> list[Shape]:
    """The first `count` shapes, from the cache where they are there."""
    collection = as_collection(collection)
    chosen = range(min(count, len(collection)))
    if cache is None or collection.key is None:
        return [collection[i] for i in chosen]
    key = fingerprint(STAGE, VERSION, [collection.shape_key(i) for i in chosen])
    arrays = cache.get(STAGE, key, lambda: _arrays([collection[i] for i in chosen]))
    return [_shape(arrays[f"vertices{i}"], arrays.get(f"faces{i}")) for i in chosen]


def _arrays(shapes: list[Shape]) -> dict[str, np.ndarray]:
    arrays = {f"vertices{i}": shape.vertices for i, shape in enumerate(shapes)}
    return arrays | {f"faces{i}": shape.faces for i, shape in enumerate(shapes) if isinstance(shape, Mesh)}


def _shape(vertices: np.ndarray, faces: np.ndarray | None) -> Shape:
    return PointCloud(vertices) if faces is None else Mesh(vertices, faces)
