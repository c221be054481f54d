"""Points of a scan in proportion to its surface: a finely scanned head does not outweigh the rest of a person."""

import numpy as np
from jaxtyping import Int

from lssd_learn.shapes import Mesh, Shape
from lssd_learn.shapes.sampling import sample_with_corners

CELL = 0.03  # metres, the side of cubes in which points of a cloud are counted


def even(shape: Shape, most: int, rng: np.random.Generator) -> Int[np.ndarray, " m"]:
    """(m,) numbers of vertices of a mesh, or of points of a cloud, in metres, `most` at most, in random order.

    Of a mesh those beside points that are uniform by area; of a cloud points are the rarer the more there are around.
    """
    if isinstance(shape, Mesh):
        return rng.permutation(np.unique(sample_with_corners(shape, most, rng)[1]))
    cubes = np.floor((shape.points - shape.points.min(axis=0)) / CELL).astype(np.int64)
    sides = cubes.max(axis=0) + 1
    codes = (cubes[:, 0] * sides[1] + cubes[:, 1]) * sides[2] + cubes[:, 2]
    _, cube, count = np.unique(codes, return_inverse=True, return_counts=True)
    # Without replacement and with weights: the first to come, each at a rate of its own (Efraimidis, Spirakis 2006).
    return np.argsort(rng.exponential(size=len(cubes)) * count[cube], kind="stable")[:most]
