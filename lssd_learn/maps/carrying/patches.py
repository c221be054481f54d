"""First step of carrying: a landmark goes from one shape to another with the patch of surface that it lies on."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from lssd_learn.kdtree import cKDTree
from lssd_learn.shapes import Mesh
from lssd_learn.shapes.kabsch import kabsch
from lssd_learn.shapes.normals import normals
from lssd_learn.shapes.triangles import triangle_normals

REACH = 0.02  # width of a patch, over √area
LEAST = 12  # vertices of one


@dataclass(frozen=True, eq=False)
class Laid:
    """L points of one shape, laid with their patches on another.

    Attributes:
        points: (L, 3) where they lie.
        turns: (L, 3, 3) orthogonal Q: an offset x from a point of the source is scale · x Q here.
        scale: of the target over the source, the root of the ratio of their areas.
    """

    points: Float[np.ndarray, "L 3"]
    turns: Float[np.ndarray, "L 3 3"]
    scale: float


def laid(
    points: Float[np.ndarray, "L 3"],
    source: Mesh,
    target: Mesh,
    corners: Int[np.ndarray, "V_source 3"],
    weights: Float[np.ndarray, "V_source 3"],
    reach: float = REACH,
) -> Laid:
    """Where points beside the source lie beside the target, by a map.

    The patch around each is laid on where the map takes it, by a turn and a shift that suit its places and its normals
    best, near vertices most (a Gaussian of width `reach`), and the point goes with it: one that lies off the surface
    stays off it, on the same side and as far. A map that turns triangles over mirrors the patch.

    Args:
        points: L points on the source or near it, in its units.
        source, target: meshes whose faces look outward, or inward, both.
        corners, weights: for each vertex of the source three vertices of the target, and its place among them.
        reach: over √area of the source.
    """
    images = np.einsum("vc,vcx->vx", weights, target.vertices[corners])
    facing = np.einsum("vc,vcx->vx", weights, normals(target)[corners])
    outward, side = normals(source), -1.0 if is_mirrored(source, images, facing) else 1.0
    scale = float(np.sqrt(target.area / source.area))
    width = reach * np.sqrt(source.area)
    tree = cKDTree(source.vertices)
    nearest = tree.query(points, min(LEAST, len(source.vertices)))[1].reshape(len(points), -1)
    made, turns = np.empty_like(points), np.empty((len(points), 3, 3))
    for number, (point, few) in enumerate(zip(points, nearest, strict=True)):
        around = np.union1d(few, tree.query_ball_point(point, 3 * width)).astype(int)
        squares = np.square(source.vertices[around] - point).sum(axis=1)
        w = np.exp(-(squares - squares.min()) / (2 * width**2))
        w = np.where(np.isin(around, few), np.maximum(w, 1e-3), w)
        w /= w.sum()
        here, there = w @ source.vertices[around], w @ images[around]
        # Normals count as points a width away: on a flat patch places alone leave open which side is up.
        before = np.concatenate([source.vertices[around] - here, width * outward[around]])
        after = np.concatenate([images[around] - there, scale * width * facing[around]])
        turns[number] = side * kabsch(side * before, after, np.concatenate([w, w]))
        made[number] = there + scale * (point - here) @ turns[number]
    return Laid(made, turns, scale)


def is_mirrored(source: Mesh, images: np.ndarray, facing: np.ndarray) -> bool:
    """Whether a map turns most of the source's triangles over.

    Args:
        source: V vertices.
        images: (V, 3) where each lies on the target.
        facing: (V, 3) the normals there.
    """
    over = np.einsum("fx,fx->f", triangle_normals(images[source.faces]), facing[source.faces].sum(axis=1)) < 0
    areas = source.face_areas
    return bool(areas[over].sum() > areas.sum() / 2)
