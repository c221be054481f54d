"""A mesh moved so that its latent coordinates are given ones, each part of it as rigidly as that allows.

Where a smooth shape is known, the detail that it lacks has to come along with the part of the body it stands on: moved
by what the smooth part moves, a hand would keep its direction while its arm turns.
"""

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


def as_rigid_as_possible(
    mesh: Mesh,
    measure: Float[np.ndarray, "m V"],
    wanted: Float[np.ndarray, "m 3"],
    start: Float[np.ndarray, "V 3"],
    rounds: int = 10,
) -> Float[np.ndarray, "V 3"]:
    """Vertices X with A X = x̂ whose edges differ least from those of the mesh, each vertex with a rotation of its own.

    Minimises Σ_v Σ_w~v w_vw ‖(X_v − X_w) − R_v (P_v − P_w)‖², in turns for the rotations R and for X, for which m
    linear conditions cost m solutions with one factorisation.

    Args:
        mesh: P, whose detail is kept.
        measure: A, what is asked of the vertices, as the coefficients of m smooth functions; with the constant.
        wanted: x̂.
        start: where the vertices are about to be.
        rounds: of both turns.

    Reference:
        Sorkine and Alexa, "As-rigid-as-possible surface modeling", Symposium on Geometry Processing (2007).
    """
    L, mass = laplacian(mesh)
    a, b, weights = _edges(L)
    along = np.arange(len(a))
    ends = np.concatenate([np.ones(len(a)), -np.ones(len(a))]), (np.tile(along, 2), np.concatenate([a, b]))
    D = csr_array(coo_array(ends, shape=(len(a), len(mass))))
    solver = splu((D.T @ diags_array(weights) @ D + ANCHOR * diags_array(mass / mass.sum())).tocsc())
    moved = solver.solve(np.ascontiguousarray(measure.T))
    conditions, edges, X = measure @ moved, D @ mesh.vertices, start
    for _ in range(rounds):
        R = _rotations(D @ X, edges, weights, a, b, len(mass))
        turned = np.einsum("eij,ej->ei", R[a] + R[b], edges) / 2
        X = solver.solve(D.T @ (weights[:, None] * turned))
        X = X + moved @ np.linalg.solve(conditions, wanted - measure @ X)
    return X


def _edges(L: csr_array) -> tuple[Int[np.ndarray, " E"], Int[np.ndarray, " E"], Float[np.ndarray, " E"]]:
    """Both ends of each edge, and its weight."""
    entries = coo_array(L)
    once = entries.row < entries.col
    weights = -np.asarray(entries.data, dtype=float)[once]
    return entries.row[once], entries.col[once], np.maximum(weights, LEAST * weights.max())


def _rotations(now, before, weights, a, b, n: int) -> Float[np.ndarray, "V 3 3"]:
    """Of each vertex that which turns its edges before (E, 3) nearest to what they are now."""
    products = (weights[:, None, None] * now[:, :, None] * before[:, None, :]).reshape(-1, 9)
    shares = csr_array(
        (np.ones(2 * len(a)), (np.concatenate([a, b]), np.tile(np.arange(len(a)), 2))), shape=(n, len(a))
    )
    return nearest_rotation((shares @ products).reshape(n, 3, 3))
