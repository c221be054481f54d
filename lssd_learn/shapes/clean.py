"""Dirty scans: between reading a file and its Laplacian. One connected piece comes out, and what was done is told."""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from lssd_learn.errors import InputError
from lssd_learn.shapes.mesh import Mesh

# A triangle is degenerate when its height is below this share of its longest edge: its cotangents would cost the
# stiffness matrix ten of its sixteen digits.
DEGENERATE = 1e-10


@dataclass(frozen=True, eq=False)
class Cleaned:
    """What `clean` made of a mesh of V vertices.

    Attributes:
        mesh: the cleaned mesh, V' ≤ V vertices, in the order they had.
        vertex_index: (V',) for each vertex of `mesh` the vertex of the original.
        new_index: (V,) for each vertex of the original the vertex of `mesh`, -1 if it was dropped.
        repairs: what was done or found, in short phrases; empty for a clean mesh.
    """

    mesh: Mesh
    vertex_index: np.ndarray
    new_index: np.ndarray
    repairs: tuple[str, ...]


def clean(mesh: Mesh, name: str = "mesh") -> Cleaned:
    """Keep the largest connected piece of `mesh` and report what may trouble its Laplacian.

    In this order: faces that name a vertex twice go (their neighbours close over them); if the mesh falls apart,
    vertices at exactly the same place become one (seams of textures); the piece of the largest area stays; vertices
    of no face go. Zero-area faces with three vertices stay, as removing them would cut slits, and so do non-manifold
    edges: both are for the robust Laplacian. A clean mesh comes back as the same object.

    Args:
        mesh: any mesh.
        name: how an error calls it, a file name perhaps.

    Raises:
        InputError: all faces have zero area.
    """
    if not mesh.area > 0:
        raise InputError(f"{name}: expected a mesh with a surface, all its {len(mesh.faces):,} faces have zero area")
    n = len(mesh.vertices)
    faces, new_index, repairs = mesh.faces, np.arange(n), []

    proper = _distinct_corners(faces)
    if not proper.all():
        faces = faces[proper]
        repairs.append(f"removed {_count((~proper).sum(), 'face')} with a repeated vertex")

    count, piece = _pieces(faces, n)
    if count > 1:
        merged = _first_at_same_place(mesh.vertices)
        merged_faces = merged[faces]
        merged_faces = merged_faces[_distinct_corners(merged_faces)]
        merged_count, merged_piece = _pieces(merged_faces, n)
        if merged_count < count:
            repairs.append(f"merged {_count((merged != new_index).sum(), 'vertex')} with others at the same place")
            faces, new_index, count, piece = merged_faces, merged, merged_count, merged_piece
    if count > 1:
        face_piece = piece[faces[:, 0]]
        largest = np.argmax(np.bincount(face_piece, Mesh(mesh.vertices, faces).face_areas))
        faces = faces[face_piece == largest]

    used = np.zeros(n, dtype=bool)
    used[faces] = True
    if count > 1:
        repairs.append(f"kept the largest of {count:,} components, {used.sum():,} of {n:,} vertices")
    elif not used[new_index].all():
        repairs.append(f"dropped {_count((~used[new_index]).sum(), 'vertex')} of no face")
    if repairs:
        position = np.where(used, np.cumsum(used) - 1, -1)
        mesh = Mesh(mesh.vertices[used], position[faces])
        new_index = position[new_index]

    found = {"zero-area face": _degenerate(mesh).sum(), "non-manifold edge": _non_manifold_edges(mesh)}
    left = [_count(number, thing) for thing, number in found.items() if number]
    if left:
        repairs.append(f"left {' and '.join(left)} to the robust Laplacian")
    return Cleaned(mesh, np.flatnonzero(used), new_index, tuple(repairs))


def is_fit_for_cotangent(mesh: Mesh) -> bool:
    """Whether the cotangent Laplacian is safe: at most two faces an edge, no zero-area face, every vertex in a face."""
    return (
        np.bincount(mesh.faces.ravel(), minlength=len(mesh.vertices)).all()
        and not _degenerate(mesh).any()
        and _non_manifold_edges(mesh) == 0
    )


def _pieces(faces: np.ndarray, n_vertices: int) -> tuple[int, np.ndarray]:
    """How many connected pieces the faces form, and for each vertex the number of its piece (any, if of no face)."""
    start, end = np.concatenate([faces[:, 0], faces[:, 1]]), np.concatenate([faces[:, 1], faces[:, 2]])
    graph = coo_array((np.ones(len(start), dtype=np.int8), (start, end)), shape=(n_vertices, n_vertices))
    _, label = connected_components(graph.tocsr(), directed=False)
    return len(np.unique(label[faces[:, 0]])), label


def _distinct_corners(faces: np.ndarray) -> np.ndarray:
    a, b, c = faces.T
    return (a != b) & (b != c) & (c != a)


def _first_at_same_place(vertices: np.ndarray) -> np.ndarray:
    """(V,) for each vertex the first one with the very same coordinates."""
    _, first, inverse = np.unique(vertices + 0.0, axis=0, return_index=True, return_inverse=True)  # -0 becomes 0
    return first[inverse.ravel()]


def _degenerate(mesh: Mesh) -> np.ndarray:
    """(F,) where a face has no area to speak of."""
    a, b, c = mesh.vertices[mesh.faces.T]
    longest = np.maximum.reduce([np.einsum("fx,fx->f", edge, edge) for edge in (b - a, c - b, a - c)])
    return 2 * mesh.face_areas <= DEGENERATE * longest


def _non_manifold_edges(mesh: Mesh) -> int:
    """The number of edges with more than two faces."""
    n, (a, b, c) = len(mesh.vertices), mesh.faces.T
    start, end = np.concatenate([a, b, c]), np.concatenate([b, c, a])
    edges = np.sort(np.minimum(start, end) * n + np.maximum(start, end))
    thrice = edges[2:][edges[2:] == edges[:-2]]
    return len(np.unique(thrice))


def _count(number: int, thing: str) -> str:
    plural = {"vertex": "vertices"}.get(thing, f"{thing}s")
    return f"{number:,} {thing if number == 1 else plural}"
