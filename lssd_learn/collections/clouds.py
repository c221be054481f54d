"""One fixed point cloud a shape, sampled from its surface: what point networks read."""

import numpy as np

from lssd_learn.cache import DEFAULT, Cache, fingerprint
from lssd_learn.collections.base import Collection
from lssd_learn.collections.given import as_collection
from lssd_learn.collections.parallel import in_parallel
from lssd_learn.errors import InputError, check_whole
from lssd_learn.shapes import sample

STAGE = "clouds"
VERSION = 1
LOST = 1e-4  # of a shape's size: a cloud with steps beyond this, far from the origin, has lost its form


def clouds(
    collection: Collection, points: int, seed: int = 0, cache: Cache | None = DEFAULT, workers: int | None = None
) -> np.ndarray:
    """Area-uniform samples (n, points, 3) float32 of every shape, in its own units.

    Args:
        collection: n shapes, a collection or a plain list.
        points: a shape.
        seed: shape i is sampled from the stream (seed, i).
        cache: where they are kept, all in one entry; None computes them.
        workers: see `in_parallel`.

    Raises:
        InputError: no points are asked for, or a shape so far from the origin that float32 has no digits for its form.
    """
    check_whole("points", points, 1)
    collection = as_collection(collection)

    def make() -> dict[str, np.ndarray]:
        out = np.empty((len(collection), points, 3), np.float32)
        samples = in_parallel(_sample, range(len(collection)), "point clouds", workers, collection, points, seed)
        for i, cloud in enumerate(samples):
            out[i] = cloud
        return {"points": out}

    if cache is None or collection.key is None:
        return make()["points"]
    return cache.get(STAGE, clouds_key(collection, points, seed), make)["points"]


def clouds_key(collection: Collection, points: int, seed: int) -> str:
    """The cache's key of the clouds."""
    return fingerprint(STAGE, VERSION, collection.key, points, seed)


def _sample(i: int, collection: Collection, points: int, seed: int) -> np.ndarray:
    cloud = sample(collection[i], points, np.random.default_rng([seed, i]))
    step, size = float(np.spacing(np.float32(np.abs(cloud).max()))), np.ptp(cloud, axis=0).max()
    if len(cloud) > 1 and step > LOST * size:
        raise InputError(
            f"{collection.names[i]}: {np.abs(cloud).max():.3g} from the origin and {size:.3g} across, where float32 "
            f"has steps of {step:.2g}: expected shapes nearer to the origin, all moved alike"
        )
    return cloud.astype(np.float32)
