"""A table as text: which separator, which encoding, a header and rows of cells. Used by `labels.py` and `landmarks.py`.

Names in a table are only ever compared with those of the shapes, never opened as paths.
"""

import codecs
import csv
import io
import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from lssd_learn.collections.reading.names import composed
from lssd_learn.errors import InputError, reading

SEPARATORS = {",": "comma", ";": "semicolon", "\t": "tab"}


@dataclass(frozen=True, eq=False)
class Table:
    """The cells of a table, stripped of the spaces around them.

    Attributes:
        path: the file.
        separator: that stands between its columns.
        columns: header → the cells below it, all of one length.
        lines: for each row the number of its line in the file.
    """

    path: Path
    separator: str
    columns: dict[str, list[str]]
    lines: list[int]

    def where(self, row: int) -> str:
        """File and line of a row, for messages."""
        return f"{self.path}, line {self.lines[row]}"


def find_table(folder: Path, name: str) -> Path | None:
    """The file `name`.csv or `name`.tsv of a folder, in capitals or not; None without.

    Raises:
        InputError: there are two.
    """
    with reading(folder):
        wanted = (f"{name}.csv", f"{name}.tsv")
        found = sorted(folder / file for file in os.listdir(folder) if file.casefold() in wanted)
    if len(found) > 1:
        raise InputError(f"{folder}: expected one table of {name}, got {found[0].name} and {found[1].name}")
    return found[0] if found else None


def read_table(path: Path, required: Sequence[str], allowed: Sequence[str] | None = None) -> Table:
    """Read a table whose columns are separated by commas, semicolons or tabs, in UTF-8, or UTF-16 with its mark.

    Args:
        path: the file.
        required: columns that must be there, in capitals or not.
        allowed: other columns that may be there; None is any.

    Raises:
        InputError: another encoding, quotes that do not close, a column that is missing, not allowed, nameless or there
            twice, a row of another length.
    """
    text = _text(path)
    separator, skipped = _separator(path, text, required)
    try:
        rows = _numbered(text, separator)
    except csv.Error as error:
        raise InputError(f"{path}: expected {SEPARATORS[separator]}-separated text in UTF-8: {error}") from error
    rows = [(number, cells) for number, cells in rows[skipped:] if any(map(str.strip, cells))]
    known = {column.casefold(): column for column in (*required, *(allowed or ()))}
    header = [column.strip() for column in (rows[0][1] if rows else [])]
    header = [known.get(column.casefold(), column) for column in header]
    for column in required:
        if column not in header:
            raise InputError(f"{path}: expected a column {column!r}, got {', '.join(header) or 'an empty file'}")
    for column in header:
        if header.count(column) > 1 or not column:
            raise InputError(f"{path}: expected each column to have a name of its own, got {column!r}")
        if allowed is not None and column not in known.values():
            raise InputError(f"{path}: expected columns {', '.join(known.values())}, got {column!r}")
    for number, cells in rows[1:]:
        if len(cells) != len(header):
            hint = "; a comma inside a number wants quotes around it" if separator == "," else ""
            raise InputError(f"{path}, line {number}: expected {len(header)} columns, got {len(cells)}{hint}")
    lines, cells = [number for number, _ in rows[1:]], zip(*(cells for _, cells in rows[1:]), strict=True)
    below = [list(map(str.strip, column)) for column in cells] or [[] for _ in header]
    return Table(path, separator, dict(zip(header, below, strict=True)), lines)


def _numbered(text: str, separator: str) -> list[tuple[int, list[str]]]:
    """The rows of a table, each with the number of the line on which it ends: a cell in quotes may hold several."""
    reader = csv.reader(io.StringIO(text, newline=""), strict=True, delimiter=separator)
    rows = list(reader)
    if reader.line_num == len(rows):
        return list(enumerate(rows, 1))
    reader = csv.reader(io.StringIO(text, newline=""), strict=True, delimiter=separator)
    return [(reader.line_num, cells) for cells in reader]


def _text(path: Path) -> str:
    with reading(path):
        data = path.read_bytes()
    wide = data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE))
    try:
        return composed(data.decode("utf-16" if wide else "utf-8-sig"))
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: expected comma-separated text in UTF-8: {error}") from error


def _separator(path: Path, text: str, required: Sequence[str]) -> tuple[str, int]:
    """What separates the columns, and how many lines stand before the header: `sep=;`, which Excel writes, is one."""
    lines = text.split("\n", 2)
    first = lines[0].strip("\r \ufeff")
    if first.casefold().startswith("sep=") and first[4:] in SEPARATORS:
        return first[4:], 1
    head = next((line.strip("\r") for line in text.split("\n") if line.strip("\r \t,;")), "")
    for separator in SEPARATORS:
        try:
            cells = next(csv.reader([head], delimiter=separator), [])
        except csv.Error:
            continue
        if set(required) <= {cell.strip().casefold() for cell in cells}:
            return separator, 0
    return max(SEPARATORS, key=head.count), 0
