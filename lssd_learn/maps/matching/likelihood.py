"""Which point of the one shape a point of the other is: by where both lie, how they face and what they look like."""

from dataclasses import dataclass

import numpy as np

from lssd_learn.kdtree import cKDTree

PLACE, NORMAL = 0.02, 0.25  # deviations of places, over √area, and of unit normals where two shapes lie on each other
TOGETHER = 0.5  # looks differ over whole regions alike, and count less than as many independent errors would
NEAR = 20  # points that come into question
TELLING = 30  # combinations of looks that differ most from point to point, against noise
LEAST_NOISE = 0.005  # of a look, against how it differs from point to point: copies have none


@dataclass(frozen=True, eq=False)
class Points:
    """n points of a surface, in the units of a likelihood.

    Attributes:
        places: (n, 3).
        rows: (n, d) places, normals and looks, each over its deviation, in single precision.
    """

    places: np.ndarray
    rows: np.ndarray


def points(places: np.ndarray, normals: np.ndarray, looks: np.ndarray) -> Points:
    """Of places (n, 3), normals (n, 3) and looks (n, e) as `whitened` makes them."""
    return Points(places, np.hstack([places / PLACE, normals / NORMAL, looks]).astype(np.float32))


def whitened(
    looks: tuple[np.ndarray, np.ndarray], there: np.ndarray, back: np.ndarray, masses: tuple[np.ndarray, np.ndarray]
) -> tuple[np.ndarray, np.ndarray]:
    """Looks of two shapes in units in which those of matched points differ by noise of one size, uncorrelated.

    What differs between the two shapes as they are matched now is what looks cannot be trusted in: nothing has to be
    known of the kind of shapes.

    Args:
        looks: (V_source, e) and (V_target, e).
        there: (V_target,) vertices of the source that the target's are matched with.
        back: (V_source,) the other way.
        masses: of the vertices, each of sum 1.
    """
    both = np.vstack(looks).astype(float)
    spread = both.std(axis=0) + np.finfo(np.float32).eps * np.abs(both).max(axis=0) + np.finfo(np.float32).tiny
    mine, theirs = ((look - both.mean(axis=0)) / spread for look in looks)
    off = np.vstack([mine - theirs[back], mine[there] - theirs]).astype(float)
    weights = np.concatenate(masses) / 2
    mean = weights @ off
    covariance = (off - mean).T @ ((off - mean) * weights[:, None])
    covariance[np.diag_indices_from(covariance)] += LEAST_NOISE**2
    scale = np.sqrt(TOGETHER) * np.linalg.inv(np.linalg.cholesky(covariance)).T
    middle = masses[1] @ theirs
    signal = scale.T @ ((theirs - middle).T @ ((theirs - middle) * masses[1][:, None])) @ scale
    scale = scale @ np.linalg.eigh(signal)[1][:, -TELLING:]
    return (mine - mean) @ scale, theirs @ scale


def likely(ours: Points, others: Points) -> tuple[np.ndarray, np.ndarray]:
    """(m, n) which of ours each of m others may be, and with what probability; rows of the latter sum to 1."""
    near = cKDTree(ours.places).query(others.places, min(NEAR, len(ours.places)))[1]
    off = ours.rows[near]
    off -= others.rows[:, None]
    half = np.einsum("mnd,mnd->mn", off, off) / 2
    odds = np.exp(half.min(axis=1, keepdims=True) - half)
    return near, odds / odds.sum(axis=1, keepdims=True)


def drawn(
    ours: tuple[np.ndarray, np.ndarray],
    others: tuple[np.ndarray, np.ndarray],
    looks: tuple[np.ndarray, np.ndarray],
    matched: tuple[np.ndarray, np.ndarray],
    masses: tuple[np.ndarray, np.ndarray],
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Where each of our points is drawn to by its likely partners, and by those whose likely partner it is.

    Args:
        ours, others: places and unit normals of n points, as they lie now, and of m.
        looks: of both, (n, e) and (m, e).
        matched: as they are now: one of ours for each of the others, (m,), and the other way, (n,).
        masses: of both, (n,) and (m,), each of sum 1.

    Returns:
        Weights (n,), places (n, 3) on the other surface, the likeliest of ours for each other (m,), and of the others
        for each of ours (n,).
    """
    mine, theirs = whitened(looks, *matched, masses)
    a, b = points(*ours, mine), points(*others, theirs)
    (near, odds), (partners, chances) = likely(a, b), likely(b, a)
    mass, count = masses[1][:, None] * odds, len(masses[0])
    flat = near.ravel()
    weights = masses[0] + np.bincount(flat, mass.ravel(), count)
    places = masses[0][:, None] * np.einsum("nk,nkx->nx", chances, b.places[partners])
    places += np.stack([np.bincount(flat, (mass * x[:, None]).ravel(), count) for x in b.places.T], axis=1)
    return weights, places / weights[:, None], _best(near, odds), _best(partners, chances)


def _best(near: np.ndarray, odds: np.ndarray) -> np.ndarray:
    return near[np.arange(len(near)), odds.argmax(axis=1)]
