"""Fewer vertices for a page that has to stay small: near ones become one."""

import numpy as np

from lssd_learn.shapes import Mesh, PointCloud, Shape

COARSER = 1.15  # the cells' growth from one try to the next


def thin(shape: Shape, most: int) -> tuple[Shape, np.ndarray]:
    """A shape of at most `most` of its own vertices, and (V',) which those are; itself where it is small enough.

    Of the vertices in each cell of a grid the one nearest to their mean stays, and faces are drawn between those that
    stay (vertex clustering: Rossignac & Borrel 1993). Good for pictures only.
    """
    points = shape.vertices
    cell = max(np.ptp(points, axis=0).max(), np.finfo(float).tiny) / max(1, most)
    if len(points) <= most:
        return shape, np.arange(len(points))
    # A surface of `most` cells has sides of about the root of that: the first try is finer than any that could do.
    cell *= most**0.5 / 2
    while True:
        cells, home = np.unique(np.floor((points - points.min(0)) / cell), axis=0, return_inverse=True)
        if len(cells) <= most:
            break
        cell *= COARSER
    home = home.ravel()
    sizes = np.bincount(home)
    means = np.stack([np.bincount(home, x) / sizes for x in points.T], axis=1)
    order = np.lexsort([np.linalg.norm(points - means[home], axis=1), home])
    kept = order[np.cumsum(sizes) - sizes]
    if not isinstance(shape, Mesh):
        return PointCloud(points[kept]), kept
    faces = home[shape.faces]
    whole = (faces != np.roll(faces, 1, axis=1)).all(1)
    return Mesh(points[kept], faces[whole]), kept
