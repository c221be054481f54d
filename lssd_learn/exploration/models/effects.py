"""How far out a statistic is among those of permutations: p, the smallest p there could be, and Z."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float
from scipy.stats import boxcox, boxcox_normmax

# Statistics nearer to each other than this part are the same up to rounding: where a term explains nearly all, what is
# left is a difference of large numbers.
SAME = 1e-7


@dataclass(frozen=True, eq=False)
class Chance:
    """What permutations say of a statistic.

    Attributes:
        found: (N,) statistics from zero on, that of the data first.
        exact: whether they are of all permutations, each once.
    """

    found: Float[np.ndarray, " N"]
    exact: bool

    @property
    def p(self) -> float:
        """The part of all, that of the data among them, that are as large."""
        return float(reached(self.found, self.found[0]).mean())

    @property
    def smallest(self) -> float:
        """The least p there could be."""
        return float(reached(self.found, self.found.max()).mean()) if self.exact else 1 / len(self.found)

    @property
    def Z(self) -> float:
        """How many standard deviations the statistic is above their mean, made normal by a Box-Cox transformation.

        Comparable between terms, shapes and operators; nan where the statistics do not vary.

        Reference:
            Collyer & Adams, "RRPP: an R package for fitting linear models to high-dimensional data using residual
            randomization", Methods in Ecology and Evolution 9 (2018).
        """
        return effect_size(self.found)


def reached(found: Float[np.ndarray, " N"], value: float) -> Bool[np.ndarray, " N"]:
    """Which are as large as a value, up to rounding."""
    return found >= value - SAME * abs(value)


def effect_size(found: Float[np.ndarray, " N"]) -> float:
    """Z of the first of N statistics, none of them negative."""
    others, largest = found[1:], np.abs(found).max()
    if len(found) < 3 or np.ptp(others) <= SAME * largest or np.median(found) <= 0:
        return float("nan")
    scaled = np.maximum(found / np.median(found), SAME)
    normal = boxcox(scaled, boxcox_normmax(scaled[1:], method="mle"))  # an outlier must not make itself normal
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
