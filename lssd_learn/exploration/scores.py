"""How well a field finds what is known to be there.

Vertices count by the area they stand for, not by how many there are: 61 % of a body's are hands and head, 16 % of its
area.
"""

import numpy as np
from jaxtyping import Bool
from numpy.typing import ArrayLike
from sklearn.metrics import roc_auc_score

from lssd_learn.errors import InputError

# Where a change is more than this part of its 99th percentile, it is to be found.
STRONG = 0.5


def strongest(change: ArrayLike, mass: ArrayLike | None = None) -> Bool[np.ndarray, " V"]:
    """(V,) bool: the vertices whose |change| exceeds half its 99th percentile over the surface.

    Args:
        change: (V,).
        mass: (V,) area of each vertex; None is the same for all.
    """
    size = np.abs(np.asarray(change, dtype=float))
    if mass is None:
        return size > STRONG * np.quantile(size, 0.99)
    return size > STRONG * np.quantile(size, 0.99, weights=_weights(mass), method="inverted_cdf")


def area_under_curve(field: ArrayLike, positive: ArrayLike, mass: ArrayLike | None = None) -> float:
    """The chance that a positive point has a larger value than another, ties counted half: the area under the ROC.

    Args:
        field: (V,) values.
        positive: (V,) bool, some and not all.
        mass: (V,) area of each vertex, the chance that a point is there; None is the same for all.

    Raises:
        InputError: none or all of the vertices are positive.
    """
    positive = np.asarray(positive, dtype=bool)
    few, most = int(positive.sum()), len(positive)
    if not 0 < few < most:
        raise InputError(f"positive: expected some of {most} vertices and not all, got {few}")
    weights = None if mass is None else _weights(mass)
    return float(roc_auc_score(positive, np.asarray(field, dtype=float), sample_weight=weights))


def correlation(a: ArrayLike, b: ArrayLike, mass: ArrayLike) -> float:
    """Pearson's, of two fields (V,) over a surface of vertex areas mass (V,); 0 where one is the same everywhere."""
    mass = _weights(mass)
    a, b = (np.asarray(field, dtype=float) for field in (a, b))
    if any(np.ptp(field) <= 1e-12 * np.abs(field).max() for field in (a, b)):
        return 0.0
    a, b = a - mass @ a, b - mass @ b
    return float(mass @ (a * b) / max(np.sqrt((mass @ a**2) * (mass @ b**2)), np.finfo(float).tiny))


def rank_correlation(a: ArrayLike, b: ArrayLike, mass: ArrayLike) -> float:
    """Spearman's, over a surface: `correlation` of the parts of its area where a field is lower, ties counted half."""
    first, second = (_ranks(np.asarray(field, dtype=float), _weights(mass)) for field in (a, b))
    return correlation(first, second, mass)


def _ranks(field: np.ndarray, mass: np.ndarray) -> np.ndarray:
    _, place = np.unique(field, return_inverse=True)
    areas = np.bincount(place, mass)
    return (np.cumsum(areas) - areas / 2)[place]


def _weights(mass: ArrayLike) -> np.ndarray:
    """(V,) float64 of sum 1."""
    mass = np.asarray(mass, dtype=float)
    return mass / mass.sum()
