"""`landmarks.csv` as it is written: that of `reading/landmark_table.py`, with how sure each place is and where from."""

import csv
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from jaxtyping import Bool, Float

from lssd_learn.collections.reading.landmark_table import CARRIED

COLUMNS = ("name", "landmark", "x", "y", "z", "error", "origin")


def write_table(
    path: Path,
    names: Sequence[str],
    labels: Sequence[str],
    points: Float[np.ndarray, "n L 3"],
    errors: Float[np.ndarray, "n L"],
    carried: Bool[np.ndarray, "n L"],
) -> None:
    """Write a row a landmark that has a place, with every digit.

    Args:
        path: of the file.
        names: of n shapes.
        labels: of L landmarks.
        points: NaN for those that have no place.
        errors: to be expected of each; NaN, left empty, where nobody knows.
        carried: which of them are not given, but carried over from other shapes: the column `origin`.
    """
    with path.open("w", newline="", encoding="utf-8") as stream:
        table = csv.writer(stream)
        table.writerow(COLUMNS)
        for i, mark in np.argwhere(np.isfinite(points).all(axis=2)).tolist():
            place = [repr(float(x)) for x in points[i, mark]]
            error = f"{errors[i, mark]:.6g}" if np.isfinite(errors[i, mark]) else ""
            table.writerow([names[i], labels[mark], *place, error, CARRIED if carried[i, mark] else "given"])
