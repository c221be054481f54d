"""One fixed point cloud a shape, sampled from its surface: what point networks read, in float32.

Far from the origin float32 has no digits left for a shape. All clouds then lie about an origin of their own, which a
trained net keeps.
"""

import numpy as np
from jaxtyping import Float

from lssd_learn.cache import DEFAULT, Cache, fingerprint
from lssd_learn.collections.base import Collection
from lssd_learn.collections.given import as_collection
from lssd_learn.collections.parallel import in_parallel
from lssd_learn.errors import InputError, check_whole
from lssd_learn.shapes import sample
from lssd_learn.shapes.writing import own_origin

STAGE, ORIGINS = "clouds", "origins"
VERSION = 1
LOST = 1e-4  # of a shape's size: a cloud with steps beyond this, far from the origin, has lost its form


def origin_of(collection: Collection, cache: Cache | None = None) -> Float[np.ndarray, "3"]:
    """(3,) zero, or, where the first shape lies far from that, a place near it: see `own_origin`."""
    collection = as_collection(collection)
    key = collection.shape_key(0)
    if cache is None or key is None:
        return own_origin(collection[0])
    arrays = cache.get(ORIGINS, fingerprint(ORIGINS, key), lambda: {"origin": own_origin(collection[0])})
    return np.array(arrays["origin"])


def clouds(
    collection: Collection,
    points: int,
    seed: int = 0,
    cache: Cache | None = DEFAULT,
    workers: int | None = None,
    origin: Float[np.ndarray, "3"] | None = None,
) -> Float[np.ndarray, "n points 3"]:
    """Area-uniform samples (n, points, 3) float32 of every shape, in its own units.

    Args:
        collection: n shapes, a collection or a plain list.
        points: a shape.
        seed: shape i is sampled from the stream (seed, i).
        cache: where they are kept, all in one entry; None computes them.
        workers: see `in_parallel`.
        origin: (3,) is taken off all points; None is zero.

    Raises:
        InputError: no points are asked for, or a shape so far from the origin that float32 has no digits for its form.
    """
    check_whole("points", points, 1)
    collection = as_collection(collection)
    origin = np.zeros(3) if origin is None else origin

    def make() -> dict[str, np.ndarray]:
        out = np.empty((len(collection), points, 3), np.float32)
        samples = in_parallel(
            _sample, range(len(collection)), "point clouds", workers, collection, points, seed, origin
        )
        for i, cloud in enumerate(samples):
            out[i] = cloud
        return {"points": out}

    if cache is None or collection.key is None:
        return make()["points"]
    return cache.get(STAGE, clouds_key(collection, points, seed, origin), make)["points"]


def clouds_key(collection: Collection, points: int, seed: int, origin: Float[np.ndarray, "3"] | None = None) -> str:
    """The cache's key of the clouds."""
    moved = [] if origin is None or not origin.any() else [origin.tolist()]
    return fingerprint(STAGE, VERSION, collection.key, points, seed, *moved)


def _sample(i: int, collection: Collection, points: int, seed: int, origin: np.ndarray) -> np.ndarray:
    cloud = sample(collection[i], points, np.random.default_rng([seed, i])) - origin
    step, size = float(np.spacing(np.float32(np.abs(cloud).max()))), np.ptp(cloud, axis=0).max()
    if len(cloud) > 1 and step > LOST * size:
        raise InputError(
            f"{collection.names[i]}: {np.abs(cloud).max():.3g} from the origin{_told(origin)} and {size:.3g} across, "
            f"where float32 has steps of {step:.2g}: expected shapes nearer to it, all moved alike"
        )
    return cloud.astype(np.float32)


def _told(origin: np.ndarray) -> str:
    return f" of the clouds ({', '.join(f'{x:.7g}' for x in origin)})" if origin.any() else ""
