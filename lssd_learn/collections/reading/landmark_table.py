"""`landmarks.csv`: which landmark of which shape lies where, as written. `landmarks.py` places them on the shapes.

What other programs write comes by way of `landmark_sources.py`.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from lssd_learn.collections.reading.names import Names
from lssd_learn.collections.reading.numbers import MISSING, each_number, number
from lssd_learn.collections.reading.table import read_table
from lssd_learn.errors import InputError

# Numbers that are written for a landmark that is not there; as a point, in all three coordinates.
CODES = {-1, -9, -99, -999, -9999, -99999, 999, 9999, 99999}
CARRIED = "carried"  # as an origin
TOLD = ("error", "origin")  # columns of `task=landmarks` that say how sure a place is and where it is from; not read


@dataclass(frozen=True, slots=True)
class Landmark:
    """A row of `landmarks.csv`: the vertex, in the numbering of the file of the shape, the point, or both.

    `where` is the file and line, for messages. A `doubtful` point may be a code for a missing one.
    """

    name: str
    vertex: int | None
    point: tuple[float, float, float] | None
    where: str
    doubtful: bool = False


@dataclass(frozen=True, eq=False)
class LandmarkTable:
    """The landmarks of n shapes in the order of the file, and the names of those that are said to be missing.

    `spaces` has the coordinate system of the points of each shape, "LPS" or "RAS", "" where none is said; `carried`
    says how many landmarks nobody placed: `task=landmarks` carried them over.
    """

    rows: list[list[Landmark]]
    missing: list[list[str]]
    spaces: tuple[str, ...] = ()
    carried: int = 0

    def space(self, i: int) -> str:
        """The coordinate system of the points of shape i."""
        return self.spaces[i] if self.spaces else ""


def read_landmarks(path: Path, names: Names | Sequence[str]) -> LandmarkTable:
    """Read `landmarks.csv`: columns `name`, `landmark` and `vertex` or `x`, `y`, `z` or both; `error`, `origin` may be.

    A landmark is missing where its cells are empty or say so (`NA`, `nan`, a vertex of -1, …); where the three
    coordinates are one such number, it is doubtful.

    Args:
        path: the file.
        names: of the shapes; some may be without landmarks.

    Raises:
        InputError: an unknown shape, a landmark given twice, a place that is no number, or one of two coordinates.
    """
    table = read_table(path, required=("name", "landmark"), allowed=("vertex", "x", "y", "z", *TOLD))
    names = names if isinstance(names, Names) else Names(names)
    columns = table.columns
    if "vertex" not in columns and not {"x", "y", "z"} <= set(columns):
        raise InputError(f"{path}: expected a column vertex or columns x, y, z, got {', '.join(columns)}")
    empty = [""] * len(table.lines)
    vertices, xyz = columns.get("vertex", empty), [columns.get(axis, empty) for axis in "xyz"]
    points = zip(*map(each_number, xyz), strict=True)
    found: list[dict[str, Landmark | None]] = [{} for _ in range(len(names))]
    rows = zip(columns["name"], columns["landmark"], vertices, zip(*xyz, strict=True), points, strict=True)
    for row, (name, mark, vertex, cells, point) in enumerate(rows):
        where = table.where(row)
        marks = found[names.position(name, where)]
        if not mark:
            raise InputError(f"{where}: expected the landmark's name, got an empty cell")
        if mark in marks:
            raise InputError(f"{where}: expected each landmark once, got {mark!r} of {name!r} again")
        place = _vertex(vertex, where), _point(point, cells, where)
        marks[mark] = None if place == (None, None) else Landmark(mark, *place, where, is_code(place[1]))
    return LandmarkTable(
        [[landmark for landmark in marks.values() if landmark is not None] for marks in found],
        [[mark for mark, landmark in marks.items() if landmark is None] for marks in found],
        carried=sum(origin == CARRIED for origin in columns.get("origin", ())),
    )


def is_code(point: Sequence[float] | None) -> bool:
    """Whether a point may be a code for a missing one."""
    return point is not None and len(set(point)) == 1 and point[0] in CODES


def _vertex(text: str, where: str) -> int | None:
    if not text or text.casefold() in MISSING:
        return None
    if text.isascii() and text.isdigit():
        return int(text)
    value = number(text)
    if value is not None and value < 0 and value in CODES:
        return None
    raise InputError(f"{where}: expected a vertex, 0 or more, or -1 for a landmark that is missing, got {text!r}")


def _point(point: tuple[float | None, ...], cells: Sequence[str], where: str) -> tuple[float, float, float] | None:
    x, y, z = point
    if x is not None and y is not None and z is not None:
        return x, y, z
    if all(not text or text.casefold() in MISSING for text in cells):
        return None
    raise InputError(f"{where}: expected a point x, y, z in numbers, got {', '.join(map(repr, cells))}")
