"""A vertex map by bending the one shape onto the other: smoothly at first, and every round less so."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from lssd_learn.errors import check_whole
from lssd_learn.kdtree import cKDTree
from lssd_learn.maps.correspondence import from_correspondence
from lssd_learn.shapes import Eigenbasis, Mesh, Shape
from lssd_learn.shapes.kabsch import kabsch
from lssd_learn.shapes.normals import normals

STIFFNESS = 1e-3  # what bending costs, at unit area, against the distance to the matched points
NORMALS = 0.05  # weight of a unit normal against a distance of √area
AFFINE, POSED = 4, 20  # functions that a motion is nearly affine with, and that can follow a change of pose
POINTS = 6000  # vertices of the source that take part while it is bent; all are matched in the end


@dataclass(frozen=True)
class Registration:
    """The choices of `registration`: of bending, so many rounds, from 4 functions to so many.

    Raises:
        InputError: a number out of its range.
    """

    rounds: int = 12
    functions: int = 80

    def __post_init__(self):
        _check(self.rounds, self.functions)


def registration(
    source: Eigenbasis, target: Eigenbasis, source_shape: Shape, target_shape: Shape, **choices
) -> Float[np.ndarray, "k_target k_source"]:
    """C (k_target, k_source), which carries functions on `source` to functions on `target`.

    For shapes that stand alike, upright and facing one way in nearly the same pose: they are laid over each other
    centre on centre, every point is matched with the nearest, and the source is bent from there (`registered`).

    Args:
        source, target: eigenbases.
        source_shape, target_shape: their shapes.
        choices: see `Registration`.

    Raises:
        InputError: a number out of its range.
    """
    there, _ = registered_vertices(source, target, source_shape, target_shape, Registration(**choices))
    return from_correspondence(source, target, there)


def registered_vertices(
    source: Eigenbasis, target: Eigenbasis, source_shape: Shape, target_shape: Shape, how: Registration
) -> tuple[Int[np.ndarray, " V_target"], Int[np.ndarray, " V_source"]]:
    """`registration` before its last step, both ways: (V_target,) vertices of the source, (V_source,) of the target."""
    both = source, target, source_shape, target_shape
    return registered(*both, *nearest_vertices(*both), from_afar(how.rounds, how.functions))


def registered(
    source: Eigenbasis,
    target: Eigenbasis,
    source_shape: Shape,
    target_shape: Shape,
    there: Int[np.ndarray, " V_target"],
    back: Int[np.ndarray, " V_source"],
    sizes: Sequence[int],
) -> tuple[Int[np.ndarray, " V_target"], Int[np.ndarray, " V_source"]]:
    """Both directions of a better vertex map: (V_target,) vertices of the source, (V_source,) of the target.

    The source is first laid on the target rigidly (Kabsch 1976). In each round it is then moved by a combination a of
    its first q eigenfunctions that takes its points near to those they are matched with,

        min_a Σ_x m_x ‖x + Φ_x a − y(x)‖² + Σ_y m_y ‖x(y) + Φ_x(y) a − y‖² + s Σ λ_f ‖a_f‖²,

    and points are matched anew with what is nearest, in position and normal. The first match settles where everything
    belongs; what is left to find is near, even where shapes are not isometric.

    Args:
        source, target, source_shape, target_shape: the two shapes. Two clouds are matched without normals; the normals
            of one are turned the way those of the other shape point.
        there: (V_target,) for each vertex of the target the vertex of the source.
        back: (V_source,) the other way.
        sizes: q of each round, ascending, see `from_afar` and `from_near`; as many as there are at most.

    Reference:
        After Eisenberger, Lähner and Cremers, "Smooth shells: multi-scale shape registration with functional maps",
        CVPR 2020, whose intrinsic features are left out; the closest points are those of Besl and McKay (1992).
    """
    X, Y, unit = source_shape.vertices, target_shape.vertices, np.sqrt(source.area)
    n = target.mass[:, None]
    every = np.arange(len(X))
    some = np.random.default_rng(0).permutation(len(X))[:POINTS]
    Phi, P = np.asarray(source.evecs, dtype=float), np.asarray(source.evecs[some], dtype=float)
    m = source.mass[some, None] * (source.area / source.mass[some].sum())
    back = back[some]
    X = _laid(X, np.concatenate([X[some], X[there]]), np.concatenate([Y[back], Y]), np.concatenate([m, n]))
    theirs = normals(target_shape)
    clouds = [not isinstance(shape, Mesh) for shape in (source_shape, target_shape)]
    weight = 0.0 if all(clouds) else NORMALS
    for number, q in enumerate(sizes, start=1):
        A, B = P[:, :q], Phi[there, :q]
        left = A.T @ (m * A) + B.T @ (n * B) + STIFFNESS * np.diag(source.evals[:q] * source.area)
        right = A.T @ (m * (Y[back] - X[some])) + B.T @ (n * (Y - X[there]))
        bent = X + Phi[:, :q] @ np.linalg.solve(left, right)
        ours = normals(source_shape, bent)
        some = some if number < len(sizes) else every
        if clouds[0]:
            ours[some] = _turned(ours[some], theirs[cKDTree(Y).query(bent[some])[1]])
        elif clouds[1]:
            theirs = _turned(theirs, ours[there])
        a, b = np.hstack([bent / unit, weight * ours])[some], np.hstack([Y / unit, weight * theirs])
        there, back = some[cKDTree(a).query(b)[1]], cKDTree(b).query(a)[1]
    return there, back


def from_afar(rounds: int, functions: int) -> list[int]:
    """The functions of each round where the shapes stand alike and the first match is rough."""
    _check(rounds, functions)
    return [round(size) for size in np.geomspace(AFFINE, functions, rounds)]


def from_near(rounds: int, functions: int) -> list[int]:
    """The functions of each round where the first match knows of another pose, which few functions cannot follow."""
    _check(rounds, functions)
    return [round(size) for size in np.linspace(min(POSED, functions), functions, rounds)]


def _check(rounds: int, functions: int) -> None:
    check_whole("rounds", rounds, 1)
    check_whole("functions", functions, AFFINE)


def nearest_vertices(
    source: Eigenbasis, target: Eigenbasis, source_shape: Shape, target_shape: Shape
) -> tuple[Int[np.ndarray, " V_target"], Int[np.ndarray, " V_source"]]:
    """(V_target,) and (V_source,) the nearest vertices on the other shape, centre on centre."""
    X, Y = (shape.vertices - basis.mass @ shape.vertices / basis.area
            for basis, shape in ((source, source_shape), (target, target_shape)))  # fmt: skip
    return cKDTree(X).query(Y)[1], cKDTree(Y).query(X)[1]


def _laid(X: np.ndarray, points: np.ndarray, goals: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """X (V, 3) by the rotation and shift that take points (N, 3) nearest to goals (N, 3), in the sense of weights."""
    total = weights.sum()
    here, there = (weights * points).sum(axis=0) / total, (weights * goals).sum(axis=0) / total
    return (X - here) @ kabsch(points - here, goals - there, weights[:, 0]) + there


def _turned(own: np.ndarray, others: np.ndarray) -> np.ndarray:
    """Normals (V, 3) known up to their sign, turned the way of others."""
    return np.where(np.einsum("vx,vx->v", own, others)[:, None] < 0, -own, own)
