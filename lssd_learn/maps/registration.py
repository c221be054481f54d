"""A vertex map made better by bending the one shape onto the other: smoothly, and every round less so."""

import numpy as np
from scipy.spatial import cKDTree

from lssd_learn.shapes import Eigenbasis, Mesh, Shape
from lssd_learn.shapes.normals import normals

STIFFNESS = 1e-3  # what bending costs, at unit area, against the distance to the matched points
NORMALS = 0.05  # weight of a unit normal against a distance of √area


def registered(
    source: Eigenbasis,
    target: Eigenbasis,
    source_shape: Shape,
    target_shape: Shape,
    there: np.ndarray,
    back: np.ndarray,
    rounds: int = 12,
    first: int = 20,
    last: int = 80,
) -> tuple[np.ndarray, np.ndarray]:
    """Both directions of a better vertex map: (V_target,) vertices of the source, (V_source,) of the target.

    The source is first laid on the target rigidly (Kabsch 1976). In each round it is then moved by a combination a of
    its first q eigenfunctions that takes its points near to those they are matched with,

        min_a Σ_x m_x ‖x + Φ_x a − y(x)‖² + Σ_y m_y ‖x(y) + Φ_x(y) a − y‖² + s Σ λ_f ‖a_f‖²,

    and points are matched anew with what is nearest, in position and normal. q grows from `first` to `last`. The first
    match settles where everything belongs; what is left to find is near, even where shapes are not isometric.

    Args:
        source, target, source_shape, target_shape: the two shapes. Two clouds are matched without normals; the normals
            of one are turned the way those of the other shape point.
        there: (V_target,) for each vertex of the target the vertex of the source.
        back: (V_source,) the other way.
        rounds: 1 or more.
        first, last: functions; as many as there are at most.

    Reference:
        After Eisenberger, Lähner and Cremers, "Smooth shells: multi-scale shape registration with functional maps",
        CVPR 2020, whose intrinsic features are left out; the closest points are those of Besl and McKay (1992).
    """
    X, Y, unit = source_shape.vertices, target_shape.vertices, np.sqrt(source.area)
    weight = 0.0 if not isinstance(source_shape, Mesh) and not isinstance(target_shape, Mesh) else NORMALS
    Phi, m, n = np.asarray(source.evecs, dtype=float), source.mass[:, None], target.mass[:, None]
    X = _laid(X, np.concatenate([X, X[there]]), np.concatenate([Y[back], Y]), np.concatenate([m, n]))
    theirs = normals(target_shape)
    if not isinstance(target_shape, Mesh):
        theirs = _turned(theirs, _normals_of(source_shape, X)[there])
    for q in np.linspace(min(first, source.k), min(last, source.k), rounds).astype(int):
        P, at = Phi[:, :q], Phi[there, :q]
        left = P.T @ (m * P) + at.T @ (n * at) + STIFFNESS * np.diag(source.evals[:q] * source.area)
        right = P.T @ (m * (Y[back] - X)) + at.T @ (n * (Y - X[there]))
        bent = X + P @ np.linalg.solve(left, right)
        ours = _normals_of(source_shape, bent)
        if not isinstance(source_shape, Mesh):
            ours = _turned(ours, theirs[back])
        a, b = np.hstack([bent / unit, weight * ours]), np.hstack([Y / unit, weight * theirs])
        there, back = cKDTree(a).query(b)[1], cKDTree(b).query(a)[1]
    return there, back


def _laid(X: np.ndarray, points: np.ndarray, goals: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """X (V, 3) by the rotation and shift that take points (N, 3) nearest to goals (N, 3), in the sense of weights."""
    total = weights.sum()
    here, there = (weights * points).sum(axis=0) / total, (weights * goals).sum(axis=0) / total
    U, _, Vt = np.linalg.svd((points - here).T @ (weights * (goals - there)))
    U[:, 2] *= np.sign(np.linalg.det(U @ Vt))
    return (X - here) @ (U @ Vt) + there


def _normals_of(shape: Shape, points: np.ndarray) -> np.ndarray:
    return normals(Mesh(points, shape.faces) if isinstance(shape, Mesh) else type(shape)(points))


def _turned(own: np.ndarray, others: np.ndarray) -> np.ndarray:
    """Normals (V, 3) known up to their sign, turned the way of others."""
    return np.where(np.einsum("vx,vx->v", own, others)[:, None] < 0, -own, own)
