"""Landmarks in the coordinate system of their shape: LPS or RAS, as 3D Slicer says of both. For `landmarks.py`."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from lssd_learn.collections.landmark_files.specimen import TO_OTHER_SPACE
from lssd_learn.collections.reading.landmark_table import Landmark
from lssd_learn.collections.reading.shape import ReadShape
from lssd_learn.collections.reading.surface import Surface, better_frame
from lssd_learn.collections.reading.told import Told


def in_space_of(
    rows: Sequence[Landmark], space: str, read: ReadShape, surface: Surface, file: str, told: Told
) -> tuple[list[Landmark], str]:
    """Landmarks in the coordinates of the file of their shape, and the system that these are in, if it is known.

    Where only the landmarks say their system, they are taken as they stand, unless they fit the surface far better in
    the other one: then they are taken so, which is a guess and told as one.

    Args:
        rows: landmarks of one shape.
        space: of their points, "LPS" or "RAS"; "" if it is not known, and then nothing is changed.
        read, surface: their shape.
        file: for messages.
    """
    points = np.array([row.point for row in rows if row.point is not None and not row.doubtful])
    if not space or space == read.space or not len(points):
        return list(rows), read.space or space
    if read.space:
        told.say(f"{file}: landmarks in {space} are taken to {read.space}, the coordinate system of their shapes")
        return _turned(rows), read.space
    own = float(np.sqrt(np.square(surface.distances(points)).mean()))
    better = better_frame(surface, points, own)
    if better is None or not np.array_equal(better[0].matrix, np.diag(TO_OTHER_SPACE)):
        told.say(f"{file}: landmarks in {space}; the shapes say no coordinate system and are taken to be in the same")
        return list(rows), space
    other = "LPS" if space == "RAS" else "RAS"
    told.warn(
        f"{file}: landmarks in {space} are off the surface as they stand and on it in {other}: "
        "that is taken for the coordinate system of the shapes, which say none"
    )
    return _turned(rows), other


def _turned(rows: Sequence[Landmark]) -> list[Landmark]:
    """Codes for missing ones stay as they are."""
    return [
        row if row.point is None or row.doubtful else replace(row, point=tuple(np.multiply(row.point, TO_OTHER_SPACE)))
        for row in rows
    ]
