"""Points on a surface: clouds that networks read and reconstructions are scored on, and spread-out points to match."""

import numpy as np
from jaxtyping import Float, Int
from scipy.sparse import csr_array

from lssd_learn.errors import InputError
from lssd_learn.shapes.mesh import Mesh, PointCloud, Shape

CANDIDATES = 10  # drawn for each of the points that `spread` keeps


def sample(shape: Shape, n: int, rng: np.random.Generator) -> Float[np.ndarray, "n 3"]:
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
    face, weights = _on_faces(shape, n, rng)
    a, b, c = shape.vertices[shape.faces[face].T]
    u, v, w = weights.T[..., None]
    return u * a + v * b + w * c


def sample_with_corners(
    mesh: Mesh, n: int, rng: np.random.Generator
) -> tuple[Float[np.ndarray, "n 3"], Int[np.ndarray, " n"]]:
    """n points (n, 3) of a mesh, as `sample` draws them, and for each (n,) the corner of its triangle that weighs most.

    Raises:
        InputError: a mesh without area.
    """
    face, weights = _on_faces(mesh, n, rng)
    corners = mesh.faces[face]
    points = np.einsum("nc,ncx->nx", weights, mesh.vertices[corners])
    return points, corners[np.arange(n), weights.argmax(axis=1)]


def spread(shape: Shape, n: int, rng: np.random.Generator) -> csr_array:
    """n points spread out over `shape`, as a sparse (n, V) matrix W: W @ f are the values of a function f (V,) there.

    On a mesh they lie anywhere on the surface, so their density does not depend on that of the vertices, and f is
    linear in each triangle. Of a cloud they are n of its points.

    Args:
        shape: a mesh or a cloud.
        n: number of points; of a cloud at most V.
        rng: the candidates are drawn from it, ten for each point.

    Raises:
        InputError: n out of range, or a mesh without area.
    """
    if isinstance(shape, PointCloud):
        chosen, weights = farthest_points(shape.points, n)[:, None], np.ones((n, 1))
    else:
        if n < 1:
            raise InputError(f"n: expected at least 1 point, got {n}")
        face, weights = _on_faces(shape, CANDIDATES * n, rng)
        corners = shape.faces[face]
        kept = farthest_points(np.einsum("nc,ncx->nx", weights, shape.vertices[corners]), n)
        chosen, weights = corners[kept], weights[kept]
    starts = np.arange(n + 1) * chosen.shape[1]
    return csr_array((weights.ravel(), chosen.ravel(), starts), shape=(n, len(shape.vertices)))


def farthest_points(points: Float[np.ndarray, "V 3"], n: int) -> Int[np.ndarray, " n"]:
    """(n,) numbers of points, spread out: each the farthest, as the crow flies, from those before it.

    The first is the farthest from the centroid, so that the order of the points matters only where distances tie.

    Args:
        points: (V, 3).
        n: 1 to V.

    Raises:
        InputError: n out of range.

    Reference:
        Eldar, Lindenbaum, Porat and Zeevi, "The farthest point strategy for progressive image sampling", IEEE
        Transactions on Image Processing 6 (1997).
    """
    if not 1 <= n <= len(points):
        raise InputError(f"n: expected 1 to {len(points)}, the points there are, got {n}")
    chosen = np.empty(n, dtype=np.int64)
    chosen[0] = _squared(points - points.mean(axis=0)).argmax()
    nearest = np.full(len(points), np.inf)
    for i in range(1, n):
        np.minimum(nearest, _squared(points - points[chosen[i - 1]]), out=nearest)
        chosen[i] = nearest.argmax()
    return chosen


def _on_faces(mesh: Mesh, n: int, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """n independent points, uniform by area: their faces (n,) and barycentric weights (n, 3)."""
    if not mesh.area > 0:
        raise InputError("shape: expected a mesh with a surface, all its faces have zero area")
    reach = np.cumsum(mesh.face_areas)
    face = np.searchsorted(reach, rng.random(n) * reach[-1], side="right")
    # √r spreads the points evenly between a corner and the opposite edge (Osada et al., "Shape distributions", 2002).
    r, s = np.sqrt(rng.random((n, 1))), rng.random((n, 1))
    return face, np.hstack([1 - r, r * (1 - s), r * s])


def _squared(vectors: np.ndarray) -> np.ndarray:
    return np.einsum("vx,vx->v", vectors, vectors)
