"""XYZ: a point a line, `x y z` and what a scanner adds. No standard says what, so it has to be known by sight."""

import re

import numpy as np

from lssd_learn.shapes.reading.columns import extras
from lssd_learn.shapes.reading.parsed import Parsed
from lssd_learn.shapes.reading.words import Numbers, text_of, whole

_COMMENT = re.compile(r"#|//|%|!")


def read(data: bytes) -> Parsed:
    """Points in the order of the file. Blank lines and comments are skipped.

    Words are separated by spaces, tabs, semicolons or commas; commas are decimal where something else separates. A
    first line may name the columns, or tell how many points there are.

    Raises:
        ValueError: a line that is no point, columns that are not known, another number of points than told.
    """
    lines = [
        (number, re.sub(r",\s+", " ", _COMMENT.split(line, maxsplit=1)[0].strip().rstrip(",;")))
        for number, line in enumerate(text_of(data).split("\n"), 1)
    ]
    header = next((line for line in text_of(data).split("\n") if line.strip()), "").strip()
    lines = [(number, line) for number, line in lines if line]
    none = np.empty((0, 3), np.int64)
    if not lines:
        return Parsed(np.empty((0, 3)), none)
    notes: list[str] = []

    count = None
    if re.fullmatch(r"\d+", lines[0][1]) and len(lines) > 1:
        count, lines = whole(lines[0][1]), lines[1:]
        notes.append("its first line taken for the number of points")
    apart = any(re.search(r"[\s;]", line) for _, line in lines)
    separator = re.compile(r"[\s;]+" if apart else r",")
    names = _names(lines[0][1], separator) or _names(re.sub(r"^\W+", "", header), re.compile(r"[\s;,]+"))
    if names and _names(lines[0][1], separator):
        lines = lines[1:]
    numbers, rows = Numbers(), []
    for number, line in lines:
        try:
            rows.append(numbers.floats(separator.split(line)))
            if len(rows[-1]) < 3:
                raise ValueError
        except ValueError:
            raise ValueError(f"line {number} does not start with three numbers: {line[:60]!r}") from None
        if len(rows[-1]) != len(rows[0]):
            raise ValueError(f"line {number} has {len(rows[-1])} columns, the first has {len(rows[0])}")
    if count is not None and count != len(rows):
        raise ValueError(f"it announces {count:,} points, {len(rows):,} are there")
    table = np.array(rows, dtype=np.float64).reshape(len(rows), -1)
    if not len(rows):
        return Parsed(np.empty((0, 3)), none)
    points, told = _points(table, names, apart)
    return Parsed(points, none, (*notes, *told, *numbers.notes))


def _names(line: str, separator: re.Pattern) -> list[str]:
    """The names of the columns, if the line tells x, y and z among them."""
    words = [word.strip("\"'").lower() for word in separator.split(line.strip())]
    return words if {"x", "y", "z"} <= set(words) and len(set(words)) == len(words) else []


def _points(table: np.ndarray, names: list[str], apart: bool) -> tuple[np.ndarray, tuple[str, ...]]:
    """The coordinates (V, 3) among the columns, and what the others are taken for."""
    width = table.shape[1]
    if len(names) == width:
        columns = [names.index(axis) for axis in "xyz"]
        others = [name for name in names if name not in "xyz"]
        return table[:, columns], (f"columns {', '.join(others)} left out",) if others else ()
    if width == 3:
        return table, ()
    if len(table) > 2 and (np.diff(table[:, 0]) == 1).all():
        raise ValueError("its first column counts the lines: expected x y z first")
    if not apart and width % 2 == 0 and (table == np.round(table)).all():
        raise ValueError("its commas may be decimal or separate: expected another separator, or decimal points")
    return table[:, :3], (f"columns behind x y z taken for {extras(table[:, 3:])}, left out",)
