"""In which unit of length a scan of a grown-up is: told by its size."""

import numpy as np

from lssd_learn.collections.columns import centroid_size
from lssd_learn.errors import InputError
from lssd_learn.shapes import Mesh, PointCloud, Shape

METRES = {"m": 1.0, "cm": 0.01, "mm": 0.001}
UNITS = ("auto", *METRES)
# Centroid sizes of grown-ups in metres: half of the generated ones lie below and above the first, and none, in whatever
# pose, is more than this factor smaller or larger.
USUAL, FACTOR = 0.42, 2.0


def find_unit(shape: Shape, unit: str = "auto") -> str:
    """The unit in which a shape is of the size of a grown-up; `unit` itself where that is said, if it can be right.

    Raises:
        InputError: none is, or not the one that is said.
    """
    if unit not in UNITS:
        raise InputError(f"unit={unit}: expected one of {', '.join(UNITS)}")
    size = centroid_size(shape)
    off = {name: abs(np.log(size * metres / USUAL)) if size > 0 else np.inf for name, metres in METRES.items()}
    near = min(off, key=lambda name: off[name])
    if unit == "auto":
        if off[near] > np.log(FACTOR):
            raise InputError(
                f"expected a body in m, cm or mm, but it is of no grown-up's size in any ({size:.3g} across)"
            )
        return near
    if off[unit] > np.log(FACTOR):
        hint = f"; it seems to be in {near}" if off[near] <= np.log(FACTOR) else ""
        raise InputError(f"expected a body in {unit}, but it is of no grown-up's size in that{hint}")
    return unit


def in_metres(shape: Shape, unit: str) -> Shape:
    """The same shape in metres."""
    if isinstance(shape, Mesh):
        return Mesh(shape.vertices * METRES[unit], shape.faces, shape.pieces)
    return PointCloud(shape.points * METRES[unit])
