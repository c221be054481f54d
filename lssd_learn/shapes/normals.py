"""Which way a surface faces at each of its points."""

import numpy as np
from jaxtyping import Float

from lssd_learn.kdtree import cKDTree
from lssd_learn.shapes.mesh import Mesh, Shape
from lssd_learn.shapes.triangles import triangle_normals

NEIGHBOURS = 12  # of a point of a cloud, itself among them


def normals(shape: Shape, points: Float[np.ndarray, "V 3"] | None = None) -> Float[np.ndarray, "V 3"]:
    """(V, 3) unit normals: of a mesh the mean of the triangles around, weighted by area; zero where they cancel.

    Of a cloud the direction in which the nearest points vary least, of either sign.

    Args:
        shape: V vertices.
        points: (V, 3) where these have moved to; None leaves them in place.
    """
    points = shape.vertices if points is None else points
    if isinstance(shape, Mesh):
        weighted = np.repeat(triangle_normals(points[shape.faces]), 3, axis=0)
        corners = shape.faces.ravel()
        sums = np.stack([np.bincount(corners, column, minlength=len(points)) for column in weighted.T], axis=1)
        lengths = np.linalg.norm(sums, axis=1, keepdims=True)
        return sums / np.where(lengths > 0, lengths, 1)
    near = points[cKDTree(points).query(points, min(NEIGHBOURS, len(points)))[1].reshape(len(points), -1)]
    near = near - near.mean(axis=1, keepdims=True)
    return np.linalg.eigh(near.transpose(0, 2, 1) @ near)[1][:, :, 0]
