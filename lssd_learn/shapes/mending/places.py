"""Which vertices lie at one place, up to a hair: what a fault of a file is told by. Used by `seams` and `sheets`."""

import numpy as np
from jaxtyping import Float, Int

from lssd_learn.kdtree import cKDTree
from lssd_learn.shapes.edges import edge_lengths, edges, groups

HAIR = 1e-6  # of the size of the shape: vertices nearer than this are meant to be at one place
ROUNDING = 2  # or nearer than so many steps of a float32, if all coordinates are such numbers
EDGE = 0.25  # but no farther than this share of the shortest edge at each of the two, or of the median edge


def places(
    vertices: Float[np.ndarray, "V 3"], faces: Int[np.ndarray, "F 3"], some: Int[np.ndarray, " S"]
) -> Int[np.ndarray, " S"]:
    """(S,) equal numbers for those of some vertices that lie at one place.

    Args:
        vertices: (V, 3).
        faces: (F, 3), from whose edges it is told what is near.
        some: (S,) vertices, in ascending order.
    """
    first, place = np.unique(vertices[some] + 0.0, axis=0, return_index=True, return_inverse=True)[1:]  # -0 becomes 0
    place = place.ravel()
    between = edges(faces)
    lengths = edge_lengths(vertices, between)
    hair = min(_hair(vertices[np.unique(faces)]), EDGE * np.median(lengths))
    at = some[first]
    near = cKDTree(vertices[at]).query_pairs(hair, output_type="ndarray")
    if not len(near):
        return place
    reach = np.full(len(vertices), np.inf)
    np.minimum.at(reach, between.ravel(), np.repeat(EDGE * lengths, 2))
    least = np.full(len(at), np.inf)
    np.minimum.at(least, place, reach[some])
    apart = np.linalg.norm(vertices[at[near[:, 0]]] - vertices[at[near[:, 1]]], axis=1)
    return groups(near[apart <= least[near].min(axis=1)], len(at))[place]


def _hair(vertices: np.ndarray) -> float:
    size = np.linalg.norm(np.ptp(vertices, axis=0))
    with np.errstate(over="ignore"):
        short = vertices.astype(np.float32)
    step = np.spacing(np.abs(short).max()) if (short == vertices).all() else 0.0
    return max(HAIR * size, ROUNDING * np.sqrt(3) * float(step))
