"""Where groups differ by their landmarks alone: the classical answer of anatomists, to compare with.

Landmarks are laid upon each other (generalised Procrustes analysis, without scale), each group has a mean, and the
thin-plate spline from one mean to the other bends space, and whatever surface lies in it.
"""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float, Int
from numpy.typing import ArrayLike
from scipy.interpolate import RBFInterpolator

from lssd_learn.collections.procrustes import procrustes
from lssd_learn.errors import InputError
from lssd_learn.shapes import Mesh

# Landmarks nearer than this part of their extent, on any shape, say nothing that one of them does not say.
NEAR = 1e-3


def landmark_means(
    landmarks: ArrayLike, labels: Sequence[str]
) -> tuple[dict[str, Float[np.ndarray, "r 3"]], Int[np.ndarray, " r"]]:
    """Means (m, 3) of the groups after Procrustes analysis of all, and which landmarks are apart on every shape.

    Args:
        landmarks: (n, m, 3).
        labels: n.

    Returns:
        Label → (r, 3), and (r,) indices of the r landmarks that were kept.

    Raises:
        InputError: another shape; fewer than four landmarks left.
    """
    landmarks = np.asarray(landmarks, dtype=float)
    if landmarks.ndim != 3 or landmarks.shape[2] != 3 or len(labels) != len(landmarks):
        raise InputError(f"landmarks: expected (n, m, 3) and n labels, got {landmarks.shape} and {len(labels)}")
    kept: list[int] = []
    extent = np.ptp(landmarks, axis=1).max()
    for j in range(landmarks.shape[1]):
        apart = [np.linalg.norm(landmarks[:, j] - landmarks[:, i], axis=1).min() > NEAR * extent for i in kept]
        kept += [j] if all(apart) else []
    if len(kept) < 4:
        raise InputError(f"landmarks: expected four or more that are apart on every shape, got {len(kept)}")
    aligned = aligned_landmarks(landmarks[:, kept])
    names = np.asarray(labels)
    return {str(label): aligned[names == label].mean(0) for label in dict.fromkeys(labels)}, np.array(kept)


def aligned_landmarks(landmarks: Float[np.ndarray, "n m 3"], scale: bool = False) -> Float[np.ndarray, "n m 3"]:
    """Landmarks of n shapes laid upon each other, see `procrustes`; with scale each of centroid size one."""
    moved = landmarks - landmarks.mean(1, keepdims=True)
    if scale:
        moved = moved / np.linalg.norm(moved, axis=(1, 2), keepdims=True)
    return moved @ procrustes(moved, np.arange(len(moved)))


def template_log_ratio(
    mesh: Mesh, landmarks: ArrayLike, first: ArrayLike, second: ArrayLike
) -> Float[np.ndarray, " V"]:
    """(V,) logarithm of the area of each vertex of a mesh brought to `second` over that brought to `first`.

    Args:
        mesh: V vertices.
        landmarks: (r, 3) of this mesh.
        first, second: (r, 3) the same, means of two groups.

    Reference:
        Bookstein, "Principal warps", IEEE Transactions on Pattern Analysis and Machine Intelligence 11 (1989); in space
        the spline of least bending is made of distances.
    """
    first, second = np.asarray(first, dtype=float), np.asarray(second, dtype=float)
    between = (first + second) / 2
    placed = _spline(np.asarray(landmarks, dtype=float), between)(mesh.vertices)
    small, large = (Mesh(_spline(between, to)(placed), mesh.faces).vertex_areas for to in (first, second))
    there = (small > 0) & (large > 0)  # a vertex with faces of no area has nothing to tell
    return np.where(there, np.log(np.where(there, large, 1) / np.where(there, small, 1)), 0.0)


def _spline(source: np.ndarray, target: np.ndarray) -> RBFInterpolator:
    return RBFInterpolator(source, target, kernel="linear", degree=1)
