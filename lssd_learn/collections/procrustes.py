"""Shapes in full vertex correspondence laid upon each other, by moving and turning them and nothing else."""

import numpy as np
from jaxtyping import Float, Float32, Int

from lssd_learn.collections.base import Collection
from lssd_learn.progress import track
from lssd_learn.shapes.kabsch import kabsch

SETTLED, MOST = 1e-6, 50  # relative change of the mean shape below which it has settled; rounds at most


def centred_vertices(collection: Collection) -> Float32[np.ndarray, "n V 3"]:
    """(n, V, 3) float32 vertices of n shapes of V vertices each, every shape moved to have its mean vertex at zero.

    Moved before they are rounded: a shape far from the origin loses nothing.
    """
    stack = np.empty((0, 0, 3), dtype=np.float32)
    for i, shape in enumerate(track(collection, "reading vertices", len(collection))):
        if i == 0:
            stack = np.empty((len(collection), *shape.vertices.shape), dtype=np.float32)
        stack[i] = shape.vertices - shape.vertices.mean(axis=0)
    return stack


def procrustes(vertices: Float[np.ndarray, "n V 3"], train: Int[np.ndarray, " t"]) -> Float[np.ndarray, "n 3 3"]:
    """Rotations that lay shapes upon the mean of some of them, in turn with the mean itself.

    Each round turns the shapes `train` upon their last mean and takes the new one (generalised Procrustes analysis:
    Gower 1975; here without scale and without reflections, all vertices alike). The other shapes are turned upon the
    mean they have no part in.

    Args:
        vertices: (n, V, 3), centred.
        train: positions of the shapes that make the mean.

    Returns:
        (n, 3, 3) float64 R: the shapes lie upon each other as `vertices @ R`.
    """
    mean = vertices[train[0]].astype(np.float64)
    for _ in range(MOST):
        before, mean = mean, np.zeros_like(mean)
        for i in train:
            mean += vertices[i] @ kabsch(vertices[i], before) / len(train)
        if np.linalg.norm(mean - before) <= SETTLED * np.linalg.norm(mean):
            break
    return np.stack([kabsch(shape, mean) for shape in vertices])
