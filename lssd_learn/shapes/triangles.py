"""Which way triangles face, and how large they are: one cross product for areas, normals and pictures."""

import numpy as np
from jaxtyping import Float


def triangle_normals(corners: Float[np.ndarray, "*many 3 3"]) -> Float[np.ndarray, "*many 3"]:
    """(…, 3) normals of triangles (…, 3, 3), a corner a row, each as long as twice the area; right-handed."""
    a, b, c = np.moveaxis(corners, -2, 0)
    return np.cross(b - a, c - a)


def enclosed(corners: Float[np.ndarray, "F 3 3"]) -> float:
    """The volume inside the triangles of a closed surface, by the divergence theorem, whichever way they are turned."""
    a, b, c = np.moveaxis(corners, 1, 0)
    return float(abs(np.einsum("fi,fi->", a, np.cross(b, c))) / 6)
