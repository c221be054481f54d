"""How good a map is: against a known correspondence, and by itself.

A vertex map is, for each of V_target vertices of the target, the vertex of the source. All distances are on the source.
"""

import numpy as np
from jaxtyping import Float, Int

from lssd_learn.kdtree import cKDTree
from lssd_learn.shapes import Mesh, Shape, laplacian
from lssd_learn.shapes.geodesics import geodesic_distances
from lssd_learn.shapes.normals import normals
from lssd_learn.shapes.triangles import triangle_normals


def geodesic_errors(
    source: Shape, found: Int[np.ndarray, " m"], true: Int[np.ndarray, " m"]
) -> Float[np.ndarray, " m"]:
    """(m,) distances along the source between found and true vertices, over the square root of its area.

    The usual score of a map is their mean. Distances are up to 3.6 % too long, see `geodesic_distances`.

    Args:
        source: a shape.
        found, true: (m,) vertices of it, one for every vertex of the target or for some of them.

    Reference:
        Kim, Lipman and Funkhouser, "Blended intrinsic maps", ACM Transactions on Graphics 30 (2011).
    """
    return geodesic_distances(source, true, found) / _size(source)


def euclidean_errors(
    source: Shape, found: Int[np.ndarray, " m"], true: Int[np.ndarray, " m"]
) -> Float[np.ndarray, " m"]:
    """(m,) straight distances between found and true vertices of the source, over the square root of its area."""
    return np.linalg.norm(source.vertices[found] - source.vertices[true], axis=1) / _size(source)


def flipped(
    side: Float[np.ndarray, " V_source"], found: Int[np.ndarray, " m"], true: Int[np.ndarray, " m"], margin: float = 0.1
) -> float:
    """The share, 0 to 1, of vertices that are mapped to the other side of a symmetric shape.

    Args:
        side: (V_source,) how far to the left (positive) or right (negative) a vertex lies: of a body, the coordinate
            across it in its rest pose.
        found, true: (m,) vertices of the source.
        margin: vertices nearer to the middle than this share of the farthest are not counted.

    Returns:
        0 where the true vertices are all in the middle.
    """
    off = np.abs(side[true]) > margin * np.abs(side).max()
    return float(np.mean(side[found[off]] * side[true[off]] < 0)) if off.any() else 0.0


def area_under_curve(errors: Float[np.ndarray, " m"], most: float = 0.25) -> float:
    """The area under the curve of how many errors are below a threshold from 0 to `most`, over `most`: 1 at best.

    Args:
        errors: (m,) over √area.
        most: where the curve ends.
    """
    return float(np.clip(1 - errors / most, 0, 1).mean())


def turned_over(
    source: Mesh,
    target: Mesh,
    there: Int[np.ndarray, " V_target"],
    facing: Float[np.ndarray, "V_source 3"] | None = None,
) -> float:
    """The share of the target's area that turns over on its way to the source; triangles that collapse don't.

    Args:
        source, target: their faces are oriented alike.
        there: (V_target,) vertices of the source.
        facing: (V_source, 3) normals of the source, where they are known.
    """
    facing = normals(source) if facing is None else facing
    corners = there[target.faces]
    over = np.einsum("fx,fx->f", triangle_normals(source.vertices[corners]), facing[corners].sum(axis=1)) < 0
    areas = target.face_areas
    return float(areas[over].sum() / areas.sum())


def coverage(mass: Float[np.ndarray, " V_source"], found: Int[np.ndarray, " V_target"]) -> float:
    """The share of the source's area whose vertices some vertex of the target is mapped to; 1 for a map onto it.

    Args:
        mass: (V_source,) areas of the vertices, `Eigenbasis.mass`.
        found: (V_target,) vertices. Fewer than V_source cannot cover the shape.
    """
    return float(mass[np.unique(found)].sum() / mass.sum())


def unreached(
    points: Float[np.ndarray, "V 3"], mass: Float[np.ndarray, " V"], found: Int[np.ndarray, " m"], radius: float
) -> float:
    """The share of the area of a shape that lies farther than `radius` from every vertex that a map leads to.

    Unlike `coverage` it hardly depends on how fine the meshes are; what the other shape lacks is not reached.

    Args:
        points: (V, 3) of the shape.
        mass: (V,) areas of its vertices.
        found: (m,) vertices of it, one for every vertex of the other shape.
        radius: in the unit of length of `points`.
    """
    away = cKDTree(points[np.unique(found)]).query(points)[0]
    return float(mass[away > radius].sum() / mass.sum())


def round_trip_errors(
    source: Shape, there: Int[np.ndarray, " V_target"], back: Int[np.ndarray, " V_source"]
) -> Float[np.ndarray, " V_source"]:
    """(V_source,) how far from home each source vertex ends up on its way to the target and back, over √area.

    Needs no known correspondence: zero for a map and its inverse.

    Args:
        source: a shape.
        there: (V_target,) for each vertex of the target the vertex of the source.
        back: (V_source,) for each vertex of the source the vertex of the target.
    """
    return geodesic_errors(source, there[back], np.arange(len(back)))


def cycle_error(*maps: np.ndarray) -> float:
    """‖C_n … C_2 C_1 − I‖_F / √k, of functional maps from a shape over others back to itself: 0 for consistent ones.

    A seam for weights of the network's edges: it needs no known correspondence. Truncation alone costs something, so
    compare only maps of equally many functions.

    Args:
        maps: C_1 (k_1, k), C_2 (k_2, k_1), … C_n (k, k_n-1), in the order they are applied; two for a pair.
    """
    around = np.eye(maps[0].shape[1])
    for C in maps:
        around = C @ around
    return float(np.linalg.norm(around - np.eye(len(around))) / np.sqrt(len(around)))


def _size(shape: Shape) -> float:
    area = shape.area if isinstance(shape, Mesh) else laplacian(shape)[1].sum()
    return float(np.sqrt(area))
