"""How far out a statistic is among those of permutations: p, the smallest p there could be, and Z."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float
from scipy.stats import boxcox

# Statistics nearer to each other than this part are the same up to rounding.
SAME = 1e-9


@dataclass(frozen=True)
class Chance:
    """What permutations say of a statistic.

    Attributes:
        p: the part of all, itself among them, that are as large.
        smallest: the least p there could be.
        Z: how many standard deviations it is above their mean, made normal by a Box-Cox transformation; nan where they
            do not vary. Comparable between terms, shapes and operators.
    """

    p: float
    smallest: float
    Z: float


def chance(found: Float[np.ndarray, " N"], exact: bool) -> Chance:
    """Of N statistics from zero on, that of the data first.

    Args:
        found: the statistics.
        exact: whether they are of all permutations, each once.

    Reference:
        Collyer & Adams, "RRPP: an R package for fitting linear models to high-dimensional data using residual
        randomization", Methods in Ecology and Evolution 9 (2018), for Z.
    """
    smallest = float(reached(found, found.max()).mean()) if exact else 1 / len(found)
    return Chance(float(reached(found, found[0]).mean()), smallest, effect_size(found))


def reached(found: Float[np.ndarray, " N"], value: float) -> Bool[np.ndarray, " N"]:
    """Which are as large as a value, up to rounding."""
    return found >= value - SAME * abs(value)


def effect_size(found: Float[np.ndarray, " N"]) -> float:
    """Z of the first of N statistics, none of them negative."""
    if np.ptp(found) <= SAME * np.abs(found).max():
        return float("nan")
    normal = boxcox(np.maximum(found, SAME * found.max()) / np.median(found))[0]
    return float((normal[0] - normal.mean()) / normal.std())


def corrected(found: Float[np.ndarray, "k N"]) -> Float[np.ndarray, " k"]:
    """p of k statistics that were looked at together, under the same N permutations: the chance that any of them has a
    p as small as this one by itself.

    Reference:
        Westfall & Young, Resampling-Based Multiple Testing (1993), the single-step minimum of p.
    """
    ranks = np.stack([_ranks(row) for row in found])
    least = ranks.min(0)
    return np.array([(least <= own + SAME).mean() for own in ranks[:, 0]])


def _ranks(found: np.ndarray) -> np.ndarray:
    """(N,) the part of all that are as large as each."""
    ordered = np.sort(found)
    return 1 - np.searchsorted(ordered, found - SAME * np.abs(found), side="left") / len(found)
