"""Which faces of a mesh are seen from outside: inner walls, pores and what lies loose inside a scan are not."""

import numpy as np
from jaxtyping import Float, Int

AXES = 24  # lines of sight, each looked along from both ends
CLOSE = 1e-9  # of the size of the shape: what is no farther in front of a face than this hides nothing


def seen_from_outside(vertices: Float[np.ndarray, "V 3"], faces: Int[np.ndarray, "F 3"]) -> Float[np.ndarray, " F"]:
    """(F,) the part of all directions, 0 to 1, in which the middle of each face looks out, past all other faces.

    Half of them on a convex surface; which way a face is turned does not matter. Rays are exact, the directions are
    twice `AXES`, the same for every shape, spread evenly over the sphere.

    Args:
        vertices: (V, 3).
        faces: (F, 3), three different vertices each.

    Reference:
        The directions are a spiral of Fibonacci's: Gonzalez, *Mathematical Geosciences* 42 (2010).
    """
    corners = vertices[faces]
    near = CLOSE * float(np.linalg.norm(np.ptp(corners, axis=(0, 1))))
    count = np.zeros(len(faces))
    for axis in _half_sphere(AXES):
        ahead, behind = _hidden(corners @ _frame(axis), near)
        count += ~ahead
        count += ~behind
    return count / (2 * AXES)


def _half_sphere(n: int) -> np.ndarray:
    """(n, 3) unit vectors with z > 0."""
    i = np.arange(n) + 0.5
    z, turn = 1 - i / n, np.pi * (1 + 5**0.5) * i
    r = np.sqrt(1 - z * z)
    return np.stack([r * np.cos(turn), r * np.sin(turn), z], axis=1)


def _frame(z: np.ndarray) -> np.ndarray:
    """(3, 3) columns: an orthonormal frame whose third is z."""
    x = np.cross(z, np.eye(3)[np.argmin(np.abs(z))])
    x /= np.linalg.norm(x)
    return np.stack([x, np.cross(z, x), z], axis=1)


def _hidden(corners: np.ndarray, near: float) -> tuple[np.ndarray, np.ndarray]:
    """(F,) whether another face stands before the middle of each, towards +z and towards −z.

    Faces are sorted into the squares of a grid that their boxes touch; each middle is tried against those of its own.
    """
    F, flat = len(corners), corners[:, :, :2]
    middle = corners.mean(axis=1)
    low, side = flat.min(axis=(0, 1)), max(2, int(np.sqrt(F)))
    step = np.maximum(np.ptp(flat, axis=(0, 1)), np.finfo(float).tiny) / side

    def cells(points: np.ndarray) -> np.ndarray:
        return np.clip(((points - low) / step).astype(np.int64), 0, side - 1)

    first, last = cells(flat.min(axis=1)), cells(flat.max(axis=1))
    wide, tall = (last - first + 1).T
    face, k = _repeated(wide * tall)
    cell = (first[face, 0] + k % wide[face]) * side + first[face, 1] + k // wide[face]
    order = np.argsort(cell, kind="stable")
    face, begin = face[order], np.searchsorted(cell[order], np.arange(side * side + 1))

    at = cells(middle[:, :2]) @ np.array([side, 1])
    ray, k = _repeated(begin[at + 1] - begin[at])
    other = face[begin[at[ray]] + k]
    ray, other = ray[ray != other], other[ray != other]
    p, (a, b, c) = middle[ray, :2], np.moveaxis(flat[other], 1, 0)
    weights = np.stack([_turn(b - p, c - p), _turn(c - p, a - p), _turn(a - p, b - p)], axis=1)
    total = weights.sum(axis=1)
    hit = ((weights >= 0).all(axis=1) | (weights <= 0).all(axis=1)) & (total != 0)
    ray, other, weights = ray[hit], other[hit], weights[hit] / total[hit, None]
    above = np.einsum("hc,hc->h", weights, corners[other, :, 2]) - middle[ray, 2]
    ahead, behind = np.zeros(F, dtype=bool), np.zeros(F, dtype=bool)
    ahead[ray[above > near]] = True
    behind[ray[above < -near]] = True
    return ahead, behind


def _turn(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]


def _repeated(counts: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Each index as often as it counts, and which time it is."""
    index = np.repeat(np.arange(len(counts)), counts)
    return index, np.arange(len(index)) - np.repeat(np.cumsum(counts) - counts, counts)
