"""Borders that run along each other, vertex by vertex: seams of textures, halves a hair apart. Part of `clean`."""

import numpy as np
from jaxtyping import Float, Int

from lssd_learn.shapes.edges import border, groups
from lssd_learn.shapes.mending.places import places


def seams(vertices: Float[np.ndarray, "V 3"], faces: Int[np.ndarray, "F 3"]) -> tuple[Int[np.ndarray, " V"], float]:
    """Which vertex each of the vertices (V,) becomes, and how far apart those are, at most, that become one.

    Two edges of the border become one if their ends are at the same places. All else stays as it is: vertices inside
    a surface that touch, and borders that meet in single points.

    Args:
        vertices: (V, 3).
        faces: (F, 3), three different vertices each.
    """
    rim, into = border(faces), np.arange(len(vertices))
    if not len(rim):
        return into, 0.0
    at, ends = np.unique(rim, return_inverse=True)  # the vertices of the border, and its edges among them
    ends = ends.reshape(-1, 2)
    place = places(vertices, faces, at)
    ends = np.take_along_axis(ends, np.argsort(place[ends], axis=1), axis=1)  # edges at one place run the same way
    _, first, edge, count = np.unique(place[ends], axis=0, return_index=True, return_inverse=True, return_counts=True)
    edge = edge.ravel()
    together = (count[edge] > 1) & (place[ends[:, 0]] != place[ends[:, 1]])
    if not together.any():
        return into, 0.0
    same = np.stack([ends[together].ravel(), ends[first[edge[together]]].ravel()], axis=1)
    label = groups(same, len(at))
    into[at] = at[np.unique(label, return_index=True)[1][label]]  # the lowest of each group
    return into, float(np.linalg.norm(vertices - vertices[into], axis=1).max())
