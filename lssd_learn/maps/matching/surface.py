"""Fifth step of matching: a point of the target goes to a point of a triangle of the source, not to a vertex."""

import numpy as np
from trimesh.triangles import closest_point, points_to_barycentric

from lssd_learn.kdtree import cKDTree

MOST = 12  # triangles around a vertex that are looked at
AROUND = 3  # vertices whose triangles are


def on_faces(
    faces: np.ndarray, points: np.ndarray, near: np.ndarray, wanted: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """(m,) faces and (m, 3) barycentric coordinates of the points of a mesh nearest to m wanted ones.

    Looked for in the triangles around a few vertices only.

    Args:
        faces: (F, 3) of the mesh.
        points: (V, 3) of its vertices.
        near: (m, n) vertices near each wanted point.
        wanted: (m, 3).

    Reference:
        Ezuz and Ben-Chen, "Deblurring and denoising of maps between shapes", Computer Graphics Forum 36 (2017), whose
        search is in the eigenfunctions.
    """
    around = _around(faces, len(points))
    candidates = around[near].reshape(len(near), -1)
    rows, columns = np.nonzero(candidates >= 0)
    tried = candidates[rows, columns]
    triangles = points[faces[tried]]
    closest = closest_point(triangles, wanted[rows])
    away = ((closest - wanted[rows]) ** 2).sum(axis=1)
    order = np.lexsort([away, rows])
    _, first = np.unique(rows[order], return_index=True)
    best = order[first]
    coordinates = np.clip(points_to_barycentric(triangles[best], closest[best]), 0, None)
    flat = ~np.isfinite(coordinates).all(axis=1)  # a triangle without area
    coordinates[flat] = (1.0, 0.0, 0.0)
    return tried[best], coordinates / coordinates.sum(axis=1, keepdims=True)


def near(points: np.ndarray, wanted: np.ndarray, matched: np.ndarray) -> np.ndarray:
    """(m, n) numbers of points near each wanted one (m, 3), the matched one (m,) among them: for `on_faces`."""
    found = cKDTree(points).query(wanted, min(AROUND, len(points)))[1]
    return np.column_stack([matched, found.reshape(len(wanted), -1)])


def _around(faces: np.ndarray, count: int) -> np.ndarray:
    """(V, MOST) faces at each vertex, −1 where there are no more."""
    corners = faces.ravel()
    order = np.argsort(corners, kind="stable")
    vertex = corners[order]
    starts = np.searchsorted(vertex, np.arange(count))
    place = np.arange(len(vertex)) - starts[vertex]
    table = np.full((count, MOST), -1)
    fits = place < MOST
    table[vertex[fits], place[fits]] = order[fits] // 3
    return table
