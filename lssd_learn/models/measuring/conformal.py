"""Split conformal prediction: intervals that hold with a given probability, whatever the reader and the errors are.

Where calibration shapes and a new one are exchangeable, and the reader has seen none of them, the new error is no
larger than the ⌈(n + 1)(1 − α)⌉-th smallest of n calibration errors with probability 1 − α or more, and at most
1 / (n + 1) more (Vovk, Gammerman & Shafer, Algorithmic Learning in a Random World, 2005; Lei et al., JASA 113, 2018).
That is so among all; among those alike it is so where these are calibrated apart (Mondrian; the same book, 4.5).
"""

import math
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

LEAST = 1e-5  # of errors, in logarithms


def conformal_width(errors: Float[np.ndarray, "n p"], level: float = 0.9) -> Float[np.ndarray, " p"]:
    """(p,) half the width of intervals that hold with probability `level`: infinite if n errors are too few for it.

    Args:
        errors: (n, p) of shapes that nothing was fitted to or chosen on; their signs do not matter.
        level: in (0, 1).
    """
    n = len(errors)
    place = math.ceil(level * (n + 1) - 1e-9)
    if place > n:
        return np.full(errors.shape[1], np.inf)
    return np.sort(np.abs(errors), axis=0)[place - 1]


@dataclass(frozen=True, eq=False)
class Widths:
    """Intervals that are wider for scans that look worse.

    How large errors are is told by a linear model of their logarithms; scans that it says to be about as doubtful make
    a class, which is calibrated by itself.

    Attributes:
        low, high: (q,) of what is seen of the scans it was calibrated on; what is beyond counts as the end.
        scales: (q + 1, p) of the linear model, a constant first.
        ends: (c − 1,) of the classes, in the mean of the logarithms.
        widths: (c, p) of the intervals over what the model says.
    """

    low: Float[np.ndarray, " q"]
    high: Float[np.ndarray, " q"]
    scales: Float[np.ndarray, "k p"]
    ends: Float[np.ndarray, " d"]
    widths: Float[np.ndarray, "c p"]

    @classmethod
    def of(
        cls, seen: Float[np.ndarray, "n q"], errors: Float[np.ndarray, "n p"], classes: int, level: float
    ) -> "Widths":
        """Calibrated on n scans, of which `seen` is known, by the logarithms of their relative errors."""
        low, high = seen.min(axis=0), seen.max(axis=0)
        rows = np.hstack([np.ones((len(seen), 1)), seen])
        scales = np.linalg.lstsq(rows, np.log(np.abs(errors) + LEAST), rcond=None)[0]
        told = rows @ scales
        doubt = told.mean(axis=1)
        ends = np.quantile(doubt, np.arange(1, classes) / classes)
        which = np.searchsorted(ends, doubt)
        widths = [conformal_width((errors / np.exp(told))[which == c], level) for c in range(classes)]
        return cls(low, high, scales, ends, np.stack(widths))

    def __call__(self, seen: Float[np.ndarray, " q"]) -> Float[np.ndarray, " p"]:
        """(p,) of one scan, in logarithms."""
        told = np.concatenate([[1.0], np.clip(seen, self.low, self.high)]) @ self.scales
        return self.widths[np.searchsorted(self.ends, told.mean())] * np.exp(told)
