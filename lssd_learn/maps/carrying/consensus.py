"""Second step of carrying: what several shapes say of where a landmark lies, made one place."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

CLEAR = 3.0  # times the typical distance from the consensus: from there on a place counts for less
ROUNDS, SETTLED = 100, 1e-9
ROUNDING = 1e-100  # where all is zero


@dataclass(frozen=True, eq=False)
class Consensus:
    """Where L landmarks of one shape lie.

    Attributes:
        points: (L, 3), NaN where nobody says anything.
        spread: (L,) root mean square distance of what was said from there, each place counted as it is there; NaN of
            fewer than two places.
        count: (L,) places that were said.
    """

    points: Float[np.ndarray, "L 3"]
    spread: Float[np.ndarray, " L"]
    count: np.ndarray


def consensus(places: Float[np.ndarray, "H L 3"]) -> Consensus:
    """One place for each landmark: the mean, but for places that are off, which count the less the farther they are.

    A place at distance d counts 1 / (1 + (d / s)²), the weight of Cauchy's distribution, s three times the median
    distance of all places of the shape: where all agree this is nearly the mean, which tells more than the median does,
    and one that is far off counts for nothing.

    Args:
        places: of L landmarks by H shapes, NaN where a shape says nothing.
    """
    said = np.isfinite(places.sum(axis=2))
    count = said.sum(axis=0)
    values = np.where(said[..., None], places, 0.0)
    points = _midmost(values, said)
    away = np.linalg.norm(values - points, axis=2) * said
    several = said & (count > 1)
    scale = CLEAR * float(np.median(away[several])) if several.any() else 0.0
    scale = max(scale, np.finfo(float).eps * np.abs(values).max(initial=0), ROUNDING)
    for _ in range(ROUNDS):
        w = said / (1 + (away / scale) ** 2)
        before = points
        points = np.einsum("hl,hlx->lx", w, values) / np.maximum(w.sum(axis=0), np.finfo(float).tiny)[:, None]
        away = np.linalg.norm(values - points, axis=2) * said
        if np.abs(points - before).max(initial=0) <= SETTLED * scale:
            break
    w = said / (1 + (away / scale) ** 2)
    squares = (w * away**2).sum(axis=0) / np.maximum(w.sum(axis=0), np.finfo(float).tiny)
    spread = np.where(count > 1, np.sqrt(squares), np.nan)
    return Consensus(np.where(count[:, None] > 0, points, np.nan), spread, count)


def _midmost(values: np.ndarray, said: np.ndarray) -> np.ndarray:
    """(L, 3) for each landmark the place that is nearest to the others; zero where there is none."""
    away = np.linalg.norm(values[:, None] - values[None], axis=3) * (said[:, None] & said[None])
    best = np.where(said, away.sum(axis=1), np.inf).argmin(axis=0)
    return values[best, np.arange(values.shape[1])]
