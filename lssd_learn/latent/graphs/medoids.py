"""The points in the midst of the others: k-medoids, the first phase of PAM (Kaufman & Rousseeuw 1990). Of many points
those of a sample serve, as in their CLARA: the midst of all is found among fewer, and the cost does not grow with n².

Each of them is the one that brings all points nearest to their own medoid, exactly. What a point gains can only fall as
others are chosen before it, so that after the second one few are looked at again (lazy greedy search, Minoux 1978).
All are looked at by products of matrices, which round a little; those that come near the best are told apart by their
distances as such.
"""

import numpy as np
from jaxtyping import Float, Int
from scipy.spatial.distance import cdist

from lssd_learn.latent.graphs.near import blocks

SLACK = 1e-7  # of a distance by a product of matrices, relative to the largest norm: the root of its rounding
MANY = 2000  # points from which on a sample of as many is taken
CACHED = 16  # a block of distances is so many times smaller than the largest that may be held: it stays in the cache


def medoids(points: Float[np.ndarray, "n d"], count: int) -> list[int]:
    """The numbers of `count` of the points (n, d), in the order in which they are chosen; of equal ones the first.

    Of more than `MANY` points they are those of a sample, the same every time, larger for more than a tenth of it.
    """
    most = max(MANY, 10 * count)
    if len(points) > most:
        sample = np.sort(np.random.default_rng(0).choice(len(points), most, replace=False))
        return sample[medoids(points[sample], count)].tolist()
    n = len(points)
    points = np.asarray(points, dtype=float)
    centred = points - points.mean(axis=0)
    squares = np.square(centred).sum(axis=1)
    slack = n * SLACK * np.sqrt(squares.max())
    away = np.full(n, np.inf)  # of each point from its medoid
    most = np.full(n, np.inf)  # that each point can gain
    chosen: list[int] = []
    for _ in range(count):
        order, gains, best = np.argsort(-most, kind="stable"), np.full(n, -np.inf), -np.inf
        for rows in blocks(order, CACHED * n):
            if most[rows[0]] + slack < best:
                break
            gains[rows] = _gains(centred, squares, rows, away)
            best = max(best, gains[rows].max())
        near = np.setdiff1d(np.flatnonzero(gains >= best - 2 * slack), chosen)
        totals = np.concatenate([np.minimum(cdist(points[s], points), away).sum(axis=1) for s in blocks(near, n)])
        known = np.isfinite(gains)
        most[known] = gains[known] + slack if chosen else np.inf  # the first choice tells nothing of the second
        chosen.append(int(near[totals.argmin()]))
        most[chosen] = -np.inf
        away = np.minimum(away, cdist(points[chosen[-1:]], points)[0])
    return chosen


def _gains(
    centred: Float[np.ndarray, "n d"],
    squares: Float[np.ndarray, " n"],
    rows: Int[np.ndarray, " r"],
    away: Float[np.ndarray, " n"],
) -> Float[np.ndarray, " r"]:
    """By how much some of the points would bring all nearer to their medoid; without one yet, less is further away."""
    D = centred[rows] @ centred.T
    D *= -2
    D += squares[rows, None]
    D += squares
    np.maximum(D, 0, out=D)
    np.sqrt(D, out=D)
    if np.isinf(away[0]):
        return -D.sum(axis=1)
    np.subtract(away, D, out=D)
    np.maximum(D, 0, out=D)
    return D.sum(axis=1)
