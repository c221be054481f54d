"""One file of a folder as the shape that is worked with, and which vertex of the file went where. For `folder.py`."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from lssd_learn.collections.reading.mask import Masks
from lssd_learn.collections.reading.pieces import chosen_pieces
from lssd_learn.collections.reading.told import Told
from lssd_learn.errors import InputError
from lssd_learn.shapes import PointCloud, Shape
from lssd_learn.shapes.clean import keep, mend
from lssd_learn.shapes.files import read


@dataclass(frozen=True, eq=False)
class ReadShape:
    """A cleaned shape.

    Attributes:
        name: of the file.
        shape: what is worked with, V' vertices.
        original: what the file holds, V vertices.
        vertex_index: (V',) for each vertex of `shape` the vertex of the original.
        new_index: (V,) for each vertex of the original the vertex of `shape`, -1 if it was dropped.
        space: "LPS" or "RAS" where the file says its coordinate system; "".
        masked: whether a mask was laid on it, so that vertices that were dropped were not asked for.
    """

    name: str
    shape: Shape
    original: Shape
    vertex_index: np.ndarray
    new_index: np.ndarray
    space: str = ""
    masked: bool = False


def read_shape(file: Path, i: int, pieces: str | None, masks: Masks, told: Told) -> ReadShape:
    """Read a file, mend it, lay a mask on it and keep some of its pieces.

    Args:
        file: of the shape.
        i: its position, by which masks know it.
        pieces: see `chosen_pieces`.
        masks: of all shapes.
        told: takes what was done.

    Raises:
        InputError: a file that cannot be read, no surface in it, a mask that does not fit, or pieces of which none is
            clearly meant.
    """
    found = read(file)
    shape = found.shape
    if found.notes:
        told.warn(f"{file.name}: {', '.join(found.notes)}")
    if isinstance(shape, PointCloud):
        if masks:
            raise InputError(f"{file}: expected a mesh for collection.mask={masks.kind}, got a point cloud")
        if file.suffix.lower() != ".xyz":
            told.say(f"{file.name}: no faces in it, taken as a point cloud")
        every = np.arange(len(shape.points))
        return ReadShape(file.name, shape, shape, every, every, found.space)
    whole = mend(shape, str(file))
    if masks:
        whole = masks.cut(i, whole, shape, found.colours, file.name)
    numbers = chosen_pieces(whole, pieces, file.name, told)
    cleaned = keep(whole, numbers)
    if cleaned.repairs:
        told.say(f"{file.name}: {', '.join(cleaned.repairs)}")
    mesh = cleaned.mesh if len(numbers) == 1 else replace(cleaned.mesh, pieces=len(numbers))
    return ReadShape(file.name, mesh, shape, cleaned.vertex_index, cleaned.new_index, found.space, bool(masks))
