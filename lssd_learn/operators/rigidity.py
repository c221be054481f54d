"""Meshes whose parts turn: with a smooth shape that they follow, or as those of another mesh do.

Where a smooth shape is known, the detail that it lacks has to come along with the part of the body it stands on: moved
by what the smooth part moves, a hand would keep its direction while its arm turns.
"""

from functools import cached_property

import numpy as np
from jaxtyping import Float, Int
from scipy.sparse import coo_array, csr_array, diags_array
from scipy.sparse.linalg import splu

from lssd_learn.shapes import Mesh
from lssd_learn.shapes.kabsch import nearest_rotation
from lssd_learn.shapes.laplacian import laplacian

# Of the largest weight: an edge between obtuse angles pulls a little too. And of the masses, so that a mesh that stands
# nowhere yet can be solved for.
LEAST, ANCHOR = 1e-6, 1e-6


def with_turned_detail(
    mesh: Mesh,
    before: Float[np.ndarray, "V 3"],
    after: Float[np.ndarray, "V 3"],
    measure: Float[np.ndarray, "m V"],
    rounds: int = 10,
) -> Float[np.ndarray, "V 3"]:
    """The vertices of a mesh whose smooth part becomes another, and whose detail turns with it.

    Minimises Σ_v Σ_w~v w_vw ‖(X_v − X_w) − (s_v − s_w) − R_v (d_v − d_w)‖² where A X = A (P + s − s₀), in turns for X,
    for which m linear conditions cost m solutions with one factorisation, and for R: each vertex has a rotation of its
    own, that which turns the edges of the mesh nearest to those of X. As "as rigid as possible", but for the smooth
    part, which stretches as it is told to.

    Args:
        mesh: P; its detail is d = P − s₀.
        before, after: s₀ and s.
        measure: A, what makes the coefficients of m smooth functions of vertices.
        rounds: of both turns.

    Reference:
        Sorkine and Alexa, "As-rigid-as-possible surface modeling", Symposium on Geometry Processing (2007).
    """
    edges, X = _Edges(mesh), mesh.vertices + after - before
    moved = edges.solver.solve(np.ascontiguousarray(measure.T))
    conditions, wanted = measure @ moved, measure @ X
    for _ in range(rounds):
        X = edges.turned(edges.rotations(mesh.vertices, X), before, after)
        X = X + moved @ np.linalg.solve(conditions, wanted - measure @ X)
    return X


def moved_alike(
    mesh: Mesh, before: Float[np.ndarray, "V 3"], after: Float[np.ndarray, "V 3"]
) -> Float[np.ndarray, "V 3"]:
    """The vertices of a mesh that moves as another of the same faces does, up to a shift: A is to B as C is to it.

    Each triangle turns and stretches as that of the other does: by the linear map that takes its edges and its unit
    normal from A to B. Where a joint bends, skin stretches: turned alone, bodies end up three times as far off. The
    vertices are those whose edges come nearest, with cotangent weights.

    Args:
        mesh: C.
        before, after: A and B.

    Reference:
        Sumner and Popović, "Deformation transfer for triangle meshes", SIGGRAPH (2004).
    """
    faces = mesh.faces
    maps = _frames(after[faces]) @ np.linalg.pinv(_frames(before[faces]))
    corners = mesh.vertices[faces]
    starts, ends = (np.roll(faces, -step, axis=1) for step in (1, 2))  # of the edge across from each corner
    u, v = (np.roll(corners, -step, axis=1) - corners for step in (1, 2))
    sines = np.linalg.norm(np.cross(u, v), axis=2)
    weights = (u * v).sum(2) / np.maximum(sines, np.finfo(float).tiny)
    weights = np.clip(weights, LEAST, 1 / LEAST).ravel()
    vectors = np.einsum("fxy,fcy->fcx", maps, u - v).reshape(-1, 3)
    difference = _difference(starts.ravel(), ends.ravel(), len(mesh.vertices))
    return _anchored(difference, weights, mesh.vertex_areas).solve(difference.T @ (weights[:, None] * vectors))


def _frames(corners: Float[np.ndarray, "F 3 3"]) -> Float[np.ndarray, "F 3 3"]:
    """Two edges and the unit normal of triangles, a column each; of one without area no normal."""
    u, v = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    normals = np.cross(u, v)
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    return np.stack([u, v, normals / np.where(lengths > 0, lengths, 1)], axis=2)


def _difference(starts: Int[np.ndarray, " E"], ends: Int[np.ndarray, " E"], count: int) -> csr_array:
    """(E, count) what makes x_start − x_end of vertices."""
    places, signs = np.tile(np.arange(len(starts)), 2), np.repeat([1.0, -1.0], len(starts))
    return csr_array(coo_array((signs, (places, np.concatenate([starts, ends]))), shape=(len(starts), count)))


def _anchored(difference: csr_array, weights: Float[np.ndarray, " E"], mass: Float[np.ndarray, " V"]):
    """The solver of the stiffness of weighed edges, anchored."""
    stiffness = difference.T @ diags_array(weights) @ difference
    return splu((stiffness + ANCHOR * diags_array(mass / mass.sum())).tocsc())


class _Edges:
    """The edges of a mesh, with cotangent weights."""

    def __init__(self, mesh: Mesh):
        L, self.mass = laplacian(mesh)
        entries = coo_array(L)
        once = entries.row < entries.col
        self.a, self.b = entries.row[once], entries.col[once]
        weights = -np.asarray(entries.data, dtype=float)[once]
        self.weights = np.maximum(weights, LEAST * weights.max())
        self.difference = _difference(self.a, self.b, len(self.mass))
        self.vectors = self.difference @ mesh.vertices

    @cached_property
    def solver(self):
        """Of the stiffness, anchored."""
        return _anchored(self.difference, self.weights, self.mass)

    def rotations(
        self, before: Float[np.ndarray, "V 3"], after: Float[np.ndarray, "V 3"]
    ) -> Float[np.ndarray, "V 3 3"]:
        """Of each vertex that which turns its edges before nearest to those after."""
        now, then = (np.asarray(self.difference @ some) for some in (after, before))
        products = (self.weights[:, None, None] * now[:, :, None] * then[:, None, :]).reshape(-1, 9)
        return nearest_rotation((abs(self.difference).T @ products).reshape(-1, 3, 3))

    def turned(
        self, rotations: Float[np.ndarray, "V 3 3"], before: Float[np.ndarray, "V 3"], after: Float[np.ndarray, "V 3"]
    ) -> Float[np.ndarray, "V 3"]:
        """The vertices whose edges are nearest to those of the mesh, turned by the rotations at both ends, but for the
        part of the mesh that is `before`: that becomes `after`."""
        rest = self.vectors - self.difference @ before
        vectors = np.einsum("eij,ej->ei", rotations[self.a] + rotations[self.b], rest) / 2 + self.difference @ after
        return self.solver.solve(self.difference.T @ (self.weights[:, None] * vectors))
