"""Columns behind x y z in a text file: normals, colours and intensities are known by their values and left out."""

import numpy as np

UNIT = 1e-2  # how far the length of a normal may be from 1


def extras(rest: np.ndarray) -> str:
    """What the columns (V, c) behind the coordinates are, in words.

    Raises:
        ValueError: they are not known.
    """
    told = []
    while rest.shape[1]:
        width = next((w for w in (3, 4, 1) if w <= rest.shape[1] and _known(rest[:, :w], rest.shape[1])), 0)
        if not width:
            raise ValueError(f"{rest.shape[1]} columns behind x y z are neither normals nor colours")
        told.append(_known(rest[:, :width], rest.shape[1]))
        rest = rest[:, width:]
    return " and ".join(told)


def _known(columns: np.ndarray, left: int) -> str:
    """What columns are, "" if that is not known; one column may be anything that a scanner tells of a point."""
    width = columns.shape[1]
    if width == 1:
        return "an intensity" if left in (1, 4) else ""
    if width == 3:
        lengths = np.linalg.norm(columns, axis=1)
        if ((np.abs(lengths - 1) <= UNIT) | (lengths == 0)).all() and lengths.any():
            return "normals"
    if (columns >= 0).all() and (columns == np.round(columns)).all() and columns.max() <= 255 and columns.max() > 1:
        return "colours" if width == 3 or left == 4 else ""
    if (columns >= 0).all() and columns.max() <= 1 and (width == 3 or left == 4):
        return "colours"
    return ""
