"""What VTK's two formats share: cells, and the surface that polygons and strips of triangles are."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from lssd_learn.shapes.reading.parsed import Parsed
from lssd_learn.shapes.reading.polygons import triangles, unrolled

# A cloud has a cell a point: a file that ends behind its points may be cut off.
POINTS_ALONE = "no cells in it, not even of its points, which are taken as a cloud"


@dataclass(frozen=True, eq=False)
class Cells:
    """Cells of one kind.

    Attributes:
        corners: (C,) of all, one cell after the other.
        counts: (P,) how many each has.
    """

    corners: Int[np.ndarray, " C"]
    counts: Int[np.ndarray, " P"]

    @classmethod
    def none(cls) -> "Cells":
        return cls(np.empty(0, np.int64), np.empty(0, np.int64))

    @classmethod
    def of_offsets(cls, corners: Int[np.ndarray, " C"], offsets: Int[np.ndarray, " O"]) -> "Cells":
        """Of where each cell begins, and the last one ends.

        Raises:
            ValueError: they do not go from 0 to C, upwards.
        """
        if len(offsets) == 0 and len(corners) == 0:
            return cls.none()
        if len(offsets) == 0 or offsets[0] != 0 or offsets[-1] != len(corners) or (np.diff(offsets) < 0).any():
            raise ValueError(f"offsets of cells: expected them to go up from 0 to {len(corners):,}")
        return cls(corners, np.diff(offsets))


def surface(
    vertices: Float[np.ndarray, "V 3"], polygons: Cells, strips: Cells, notes: Sequence[str] = (), space: str = ""
) -> Parsed:
    """The faces of polygons, and behind them those of strips.

    Raises:
        ValueError: a corner that is no vertex, a polygon that crosses itself.
    """
    parts = [unrolled(strip) for strip in np.split(strips.corners, np.cumsum(strips.counts)[:-1])]
    cut = np.concatenate([np.empty((0, 3), np.int64), *parts])
    corners = np.concatenate([polygons.corners, cut.ravel()])
    faces, told = triangles(vertices, corners, np.concatenate([polygons.counts, np.full(len(cut), 3)]))
    return Parsed(vertices, faces, (*told, *notes), space)
