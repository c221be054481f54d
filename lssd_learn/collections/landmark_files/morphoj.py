"""The row/column text of MorphoJ, which geomorph and spreadsheets hold too: a specimen a line, id, x1, y1, z1, x2, …

Reference:
    Klingenberg, MorphoJ user's guide, "Input file types".
"""

import csv
import io
import re
from collections.abc import Sequence

from lssd_learn.collections.landmark_files.specimen import Specimen, numbered, place, specimen, words_of
from lssd_learn.collections.reading.numbers import MISSING, number
from lssd_learn.shapes.reading.words import Numbers

# A column of a landmark: the axis before its name or number, or behind it.
_COLUMN = re.compile(
    r"(?P<a>[xyz])[ _.\-]?(?P<name>\d+)|(?P<before>.+?)[ _.\-](?P<b>[xyz])|(?P<n>\d+)(?P<c>[xyz])", re.I
)


def is_morphoj(text: str) -> bool:
    """Whether the first lines of a text are a table of this format: a name and three numbers a landmark in each."""
    rows = [cells for _, cells in _rows(text)[:2]]
    if not rows or "landmark" in map(str.casefold, rows[0]):
        return False
    cells = rows[0] if _is_data(rows[0]) else rows[-1]
    return len(cells) > 3 and len(cells) % 3 == 1 and _is_data(cells)


def read(text: str) -> list[Specimen]:
    """The specimens of a file; landmarks by the names in its first line, or by their order where it has none.

    Columns are separated by tabs, semicolons or commas. A first line that is not all numbers names them; names that
    tell no axes (X1, X2, X3, …, as Morpho's `r2morphoj` writes) are passed over, as MorphoJ does.

    Raises:
        ValueError: a line of another length or without a name, columns that are not x, y and z in turn.
    """
    rows, numbers = _rows(text), Numbers()
    header, rows = _header(rows)
    labels = numbered(len(rows[0][1]) // 3) if not header and rows else _labels(header)
    if rows and not labels:
        raise ValueError(f"line {rows[0][0]}: expected a name and x, y, z of landmarks, got {rows[0][1][0][:30]!r}")
    found: list[Specimen] = []
    for line, cells in rows:
        try:
            if len(cells) != 3 * len(labels) + 1:
                raise ValueError(f"expected a name and {len(labels):,} times x, y, z, got {len(cells):,} columns")
            if not cells[0]:
                raise ValueError("expected the name of a specimen, got an empty cell")
            points = [place(cells[i : i + 3], numbers) for i in range(1, len(cells), 3)]
        except ValueError as error:
            raise ValueError(f"line {line}: {error}") from None
        found.append(specimen(cells[0], labels, points, notes=numbers.notes))
    if not found:
        raise ValueError("expected a line a specimen, found none")
    return found


def _rows(text: str) -> list[tuple[int, list[str]]]:
    """The cells of each line that has any, with its number."""
    lines = text.split("\n")
    head = next((line for line in lines if line.strip()), "")
    separator = next((mark for mark in "\t;," if mark in head), "\t")
    rows = csv.reader(io.StringIO(text, newline=""), delimiter=separator)
    try:
        return [(rows.line_num, [cell.strip() for cell in row]) for row in rows if any(map(str.strip, row))]
    except csv.Error as error:
        raise ValueError(f"expected a table: {error}") from None


def _is_data(cells: list[str]) -> bool:
    return all(not cell or cell.casefold() in MISSING or number(cell) is not None for cell in cells[1:])


def _header(rows: list[tuple[int, list[str]]]) -> tuple[list[str], list[tuple[int, list[str]]]]:
    """The names of the columns, none without, and the lines of specimens."""
    if not rows or _is_data(rows[0][1]):
        return [], rows
    names = rows[0][1][1:]
    return ([] if {axis for _, axis in map(_column, names)} in ({"x"}, {""}) else names), rows[1:]


def _labels(header: list[str]) -> list[str]:
    columns = [_column(cell) for cell in header]
    labels = [name for name, axis in columns if axis == "x"]
    if columns != [(label, axis) for label in labels for axis in "xyz"]:
        raise ValueError(f"expected columns x, y, z of one landmark after the other, got {', '.join(header)[:80]}")
    return labels


def _column(cell: str) -> tuple[str, str]:
    """The landmark and the axis that a column is named after; "" for none."""
    match = _COLUMN.fullmatch(cell)
    if not match:
        return "", ""
    return match["name"] or match["before"] or match["n"], (match["a"] or match["b"] or match["c"]).lower()


def write(specimens: Sequence[Specimen]) -> str:
    """The table of many specimens with the same landmarks, separated by tabs; a missing one is NA.

    Raises:
        ValueError: other landmarks.
    """
    labels = specimens[0].labels if specimens else ()
    if any(one.labels != labels for one in specimens):
        raise ValueError("expected the same landmarks of all specimens")
    header = [f"{axis}{label}" if label.isdecimal() else f"{label}_{axis}" for label in labels for axis in "xyz"]
    stream = io.StringIO()
    rows = csv.writer(stream, delimiter="\t", lineterminator="\n")
    rows.writerow(["ID", *header])
    for one in specimens:
        rows.writerow([one.name, *(word for point in one.points for word in words_of(point, "NA"))])
    return stream.getvalue()
