"""Whether embedded shapes go round in their order, as the frames of a repeated movement should."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from lssd_learn.errors import InputError


@dataclass(frozen=True)
class Turning:
    """How points go round their mean, one after the other.

    Attributes:
        turns: all angles between a point and the next together, in turns, positive.
        smallest: degrees, the smallest of these angles; below 0 a point goes back.
    """

    turns: float
    smallest: float


def turning(points: ArrayLike) -> Turning:
    """How n points (n, 2) in the plane go round their mean.

    Angles are of the circle that the points fill when both axes are scaled to one length, so that a flat ellipse is no
    other than a circle.

    Raises:
        InputError: another shape, fewer than three points, points on a line.
    """
    points = np.asarray(points, dtype=float)
    if points.ndim != 2 or points.shape[1] != 2 or len(points) < 3:
        raise InputError(f"points: expected (n, 2) and three or more, got {points.shape}")
    centred = points - points.mean(0)
    U, s, _ = np.linalg.svd(centred, full_matrices=False)
    if s[1] <= 1e-9 * s[0]:
        raise InputError("points: expected some that are not on a line")
    angles = np.arctan2(U[:, 1], U[:, 0])
    steps = (np.diff(angles) + np.pi) % (2 * np.pi) - np.pi
    steps *= np.sign(steps.sum()) or 1
    return Turning(float(steps.sum() / (2 * np.pi)), float(np.degrees(steps.min())))
