"""Which of the connected pieces of a mesh are kept: the largest, all of them, or the one on a side. For `shape.py`."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Int

from lssd_learn.collections.reading.told import Told
from lssd_learn.errors import InputError, some_of
from lssd_learn.shapes import Mesh
from lssd_learn.shapes.clean import Cleaned

PIECES = (None, "largest", "all", "left", "right")
TOO_MUCH = 0.5  # of the area in other pieces than the largest is refused unless asked for
MUCH = 0.1  # is a warning
EQUAL = 0.8  # of two pieces, the smaller has so much of the area of the larger: which is meant is anyone's guess
CRUMB = 0.1  # of the largest piece's area: below, a piece is no side

CHOICES = "collection.pieces=largest, all, left or right"


def chosen_pieces(whole: Cleaned, pieces: str | None, name: str, told: Told) -> Sequence[int]:
    """The numbers of the pieces to keep, 0 the largest; what may be wrong about it is said.

    "left" and "right" are the pieces of the smallest and the largest mean x, as the file has it, of those that have at
    least a tenth of the area of the largest.

    Args:
        whole: a mesh with all its pieces.
        pieces: one of `PIECES`; None is the largest, if it is clear which that is, and it is most of the shape.
        name: of the file.
        told: takes warnings.

    Raises:
        InputError: with None, half of the area or more would be dropped, or two pieces are nearly equal; with "left" or
            "right", a mesh of a single piece, or pieces of which one is not beside the other.
    """
    areas = whole.piece_areas
    count, rest = len(areas), 1 - areas[0] / areas.sum()
    if pieces == "all":
        return range(count)
    if pieces in ("left", "right"):
        return [_side(whole, pieces, name)]
    if count == 1:
        return [0]
    equal = bool(areas[1] >= EQUAL * areas[0])
    if pieces is None and equal:
        raise InputError(
            f"{name}: expected one piece that is larger than the others, got {count:,}, the two largest of area "
            f"{areas[0]:.4g} and {areas[1]:.4g}: which is meant? ({CHOICES})"
        )
    if pieces is None and rest > TOO_MUCH:
        raise InputError(
            f"{name}: expected one connected piece, got {count:,}: {100 * rest:.0f} % of the area is outside the "
            f"largest and would be dropped ({CHOICES})"
        )
    if rest > MUCH:
        also = f", and the largest is hardly larger than the next ({areas[1] / areas[0]:.0%} of its area)" * equal
        told.warn(
            f"{name}: {100 * rest:.0f} % OF THE AREA IS DROPPED: only the largest of {count:,} pieces is kept{also} "
            f"({CHOICES})"
        )
    return [0]


class KeptPieces:
    """Takes one shape after another, and says where another piece is kept of files that have the same faces.

    Args:
        names: of the shapes.
        told: takes what is found.
    """

    def __init__(self, names: Sequence[str], told: Told):
        self._names, self._told = names, told
        self._kept: dict[str, dict[bytes, list[int]]] = {}

    def add(self, i: int, original: Mesh, vertex_index: Int[np.ndarray, " W"]) -> None:
        """Shape i: what its file holds, and which of its vertices were kept."""
        if len(vertex_index) < len(original.vertices):
            self._kept.setdefault(original.connectivity, {}).setdefault(vertex_index.tobytes(), []).append(i)

    def tell(self, masked: bool = False) -> None:
        """Warn of those of which another piece is kept than of most: a right one perhaps, among left ones.

        Args:
            masked: whether a mask was laid on the shapes, which leaves other vertices of each.
        """
        why = "ANOTHER PIECE IS KEPT than of {}, whose file has the same faces: a right one among left ones? "
        hint = "(collection.pieces=left or right keeps those of one side)"
        if masked:
            why = "OTHER VERTICES ARE LEFT than of {}, whose file has the same faces: no correspondence is known now "
            hint = "(collection.mask=vertices with one list for all keeps it)"
        for kinds in self._kept.values():
            most = max(kinds.values(), key=len)
            others = sorted(i for members in kinds.values() if members is not most for i in members)
            if others:
                who = some_of([self._names[i] for i in others], 1)
                self._told.warn(f"{who}: {why.format(self._names[most[0]])}{hint}")


def _side(whole: Cleaned, side: str, name: str) -> int:
    """The number of the piece on one side."""
    areas = whole.piece_areas
    large = np.flatnonzero(areas >= CRUMB * areas[0])
    if len(large) < 2:
        raise InputError(f"{name}: expected two pieces or more to choose the {side} of, got {len(large)} of any size")
    mesh = whole.mesh
    middle = mesh.vertices[mesh.faces].mean(axis=1)[:, 0]
    piece = whole.piece[mesh.faces[:, 0]]
    sums, weights = (np.bincount(piece, mesh.face_areas * x, minlength=len(areas)) for x in (middle, 1.0))
    x = sums[large] / weights[large]
    order = np.argsort(x)
    first, second = order[:2] if side == "left" else order[:-3:-1]
    if np.isclose(x[first], x[second], rtol=0, atol=0.02 * np.ptp(mesh.vertices[:, 0])):
        raise InputError(f"{name}: expected a piece farthest to the {side}, two of them are at x = {x[first]:.4g}")
    return int(large[first])
