"""Points on a surface: the clouds that point networks read and that reconstructions are scored on."""

import numpy as np

from lssd_learn.errors import InputError
from lssd_learn.shapes.mesh import PointCloud, Shape


def sample(shape: Shape, n: int, rng: np.random.Generator) -> np.ndarray:
    """n points of `shape`, (n, 3) float64: on a mesh independent and uniform by area.

    Of a cloud, n of its points, each at most once as long as there are enough; otherwise all of them, and further
    ones drawn again.

    Raises:
        InputError: n below 1, or a mesh without area.
    """
    if n < 1:
        raise InputError(f"n: expected at least 1 point, got {n}")
    if isinstance(shape, PointCloud):
        count = len(shape.points)
        rounds = [rng.permutation(count)[: n - drawn] for drawn in range(0, n, count)]
        return shape.points[np.concatenate(rounds)]
    if not shape.area > 0:
        raise InputError("shape: expected a mesh with a surface, all its faces have zero area")
    reach = np.cumsum(shape.face_areas)
    face = np.searchsorted(reach, rng.random(n) * reach[-1], side="right")
    # √r spreads the points evenly between a corner and the opposite edge (Osada et al., "Shape distributions", 2002).
    r, s = np.sqrt(rng.random((n, 1))), rng.random((n, 1))
    a, b, c = shape.vertices[shape.faces[face].T]
    return (1 - r) * a + r * (1 - s) * b + r * s * c
