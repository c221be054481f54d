"""Plane sections of a surface, and the tape laid around one. Used by `measures.py`."""

import numpy as np
from jaxtyping import Float, Int
from scipy.spatial import ConvexHull


def section(
    vertices: Float[np.ndarray, "V 3"],
    edges: Int[np.ndarray, "E 2"],
    point: Float[np.ndarray, "3"],
    normal: Float[np.ndarray, "3"],
) -> Float[np.ndarray, "m 3"]:
    """(m, 3) the points in which edges (E, 2) of a mesh pass through the plane at `point` with this normal."""
    return between(vertices, *crossed(vertices, edges, point, normal))


def between(
    vertices: Float[np.ndarray, "V 3"], ends: Int[np.ndarray, "m 2"], share: Float[np.ndarray, " m"]
) -> Float[np.ndarray, "m 3"]:
    """(m, 3) the points that are so far on the way from the first of two vertices to the second."""
    return (1 - share[:, None]) * vertices[ends[:, 0]] + share[:, None] * vertices[ends[:, 1]]


def crossed(
    vertices: Float[np.ndarray, "V 3"],
    edges: Int[np.ndarray, "E 2"],
    point: Float[np.ndarray, "3"],
    normal: Float[np.ndarray, "3"],
) -> tuple[Int[np.ndarray, "m 2"], Float[np.ndarray, " m"]]:
    """(m, 2) the edges that pass through the plane at `point` with this normal, and (m,) the part of each before it."""
    away = (vertices - point) @ normal
    start, end = away[edges].T
    passing = (start < 0) != (end < 0)
    start, end = start[passing], end[passing]
    return edges[passing], start / (start - end)


def tape(points: Float[np.ndarray, "m 3"], normal: Float[np.ndarray, "3"]) -> tuple[float, Float[np.ndarray, "h 3"]]:
    """What a tape around points of a plane measures, which spans their hollows, and (h, 3) the points it lies on.

    The perimeter of their convex hull, in their unit; the plane has this normal.
    """
    first = np.cross(normal, np.eye(3)[np.abs(normal).argmin()])
    first = first / np.linalg.norm(first)
    second = np.cross(normal, first) / np.linalg.norm(normal)
    hull = ConvexHull(points @ np.stack([first, second], axis=1))
    return float(hull.area), points[hull.vertices]  # of a plane set scipy's area is the perimeter


def loop_length(points: Float[np.ndarray, "m 3"]) -> float:
    """The length of the closed polygon through points (m, 3), in their order and unit."""
    return float(np.linalg.norm(np.roll(points, 1, axis=0) - points, axis=1).sum())
