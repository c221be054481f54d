"""How well a field finds what is known to be there."""

import numpy as np
from numpy.typing import ArrayLike
from sklearn.metrics import roc_auc_score

from lssd_learn.errors import InputError

# Where a change is more than this part of its 99th percentile, it is to be found.
STRONG = 0.5


def strongest(change: ArrayLike) -> np.ndarray:
    """(V,) bool: the vertices whose |change| exceeds half its 99th percentile over the vertices."""
    size = np.abs(np.asarray(change, dtype=float))
    return size > STRONG * np.quantile(size, 0.99)


def area_under_curve(field: ArrayLike, positive: ArrayLike) -> float:
    """The chance that a positive vertex has a larger value than another, ties counted half: the area under the ROC.

    Args:
        field: (V,) values.
        positive: (V,) bool, some and not all.

    Raises:
        InputError: none or all of the vertices are positive.
    """
    positive = np.asarray(positive, dtype=bool)
    few, most = int(positive.sum()), len(positive)
    if not 0 < few < most:
        raise InputError(f"positive: expected some of {most} vertices and not all, got {few}")
    return float(roc_auc_score(positive, np.asarray(field, dtype=float)))
