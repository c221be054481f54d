"""First step of carrying: a landmark goes from one shape to another with the patch of surface that it lies on."""

import numpy as np
from jaxtyping import Float, Int

from lssd_learn.kdtree import cKDTree
from lssd_learn.shapes import Mesh
from lssd_learn.shapes.kabsch import kabsch
from lssd_learn.shapes.normals import normals
from lssd_learn.shapes.triangles import triangle_normals

REACH = 0.02  # width of a patch, over √area
LEAST = 12  # vertices of one


def carried(
    points: Float[np.ndarray, "L 3"],
    source: Mesh,
    target: Mesh,
    corners: Int[np.ndarray, "V_source 3"],
    weights: Float[np.ndarray, "V_source 3"],
    reach: float = REACH,
) -> Float[np.ndarray, "L 3"]:
    """Where points beside the source lie beside the target, by a map.

    The patch around each is laid on where the map takes it, by a turn and a shift that suit its places and its normals
    best, near vertices most (a Gaussian of width `reach`), and the point goes with it: one that lies off the surface
    stays off it, on the same side and as far. A map that turns triangles over mirrors the patch.

    Args:
        points: L points on the source or near it, in its units.
        source, target: meshes whose faces look outward, or inward, both.
        corners, weights: for each vertex of the source three vertices of the target, and its place among them.
        reach: over √area of the source.

    Returns:
        In the units of the target.
    """
    images = np.einsum("vc,vcx->vx", weights, target.vertices[corners])
    facing = np.einsum("vc,vcx->vx", weights, normals(target)[corners])
    outward, side = normals(source), -1.0 if is_mirrored(source, images, facing) else 1.0
    scale = np.sqrt(target.area / source.area)
    width = reach * np.sqrt(source.area)
    tree = cKDTree(source.vertices)
    nearest = tree.query(points, min(LEAST, len(source.vertices)))[1].reshape(len(points), -1)
    made = []
    for point, few in zip(points, nearest, strict=True):
        around = np.union1d(few, tree.query_ball_point(point, 3 * width)).astype(int)
        away = np.linalg.norm(source.vertices[around] - point, axis=1)
        w = np.exp(-((away**2) - away.min() ** 2) / (2 * width**2))
        w = np.where(np.isin(around, few), np.maximum(w, 1e-3), w)
        w /= w.sum()
        here, there = w @ source.vertices[around], w @ images[around]
        # Normals count as points a width away: on a flat patch places alone leave open which side is up.
        before = np.concatenate([source.vertices[around] - here, width * outward[around]])
        after = np.concatenate([images[around] - there, scale * width * facing[around]])
        turn = side * kabsch(side * before, after, np.concatenate([w, w]))
        made.append(there + scale * (point - here) @ turn)
    return np.array(made).reshape(-1, 3)


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
