"""OFF, the text format of Geomview: vertices, then faces as counts and numbers; with normals, colours and textures."""

import re

import numpy as np

from lssd_learn.shapes.reading.columns import extras
from lssd_learn.shapes.reading.parsed import Parsed
from lssd_learn.shapes.reading.polygons import triangles
from lssd_learn.shapes.reading.words import Numbers, rows_of, text_of, whole

Row = list[str]


def read(data: bytes) -> Parsed:
    """Vertices and faces in the order of the file.

    Raises:
        ValueError: a line that does not fit, less or more than the counts say, four or n coordinates, the binary form.
    """
    if re.match(rb"\s*\S*OFF\s+BINARY", data):
        raise ValueError("it is binary OFF, which is not read: expected the text form")
    rows, lines = rows_of(text_of(data))
    kind, rows, lines = _header(rows, lines)
    if not rows or not 2 <= len(rows[0]) <= 3:
        raise ValueError("expected the numbers of vertices and faces in its first line")
    V, F = whole(rows[0][0]), whole(rows[0][1])
    if V < 0 or F < 0:
        raise ValueError(f"it announces {V} vertices and {F} faces")
    body, lines, numbers = rows[1:], lines[1:], Numbers()
    if len(body) != V + F or any(len(row) < 3 for row in body[:V]):
        body, lines = _unwrapped(body, V, F, kind), None
    try:
        vertices, notes = _vertices(body[:V], kind, numbers, lines)
        corners, counts = _faces(body[V:], lines and lines[V:])
    except _BadRow as bad:
        where = f"line {bad.line}" if bad.line else "a line"
        raise ValueError(f"{where} does not fit: {' '.join(bad.row)[:60]!r}") from None
    faces, told = triangles(vertices, corners, counts)
    return Parsed(vertices, faces, (*notes, *told, *numbers.notes))


class _BadRow(Exception):
    def __init__(self, row: Row, line: int | None):
        self.row, self.line = row, line


def _header(rows: list[Row], lines: list[int]) -> tuple[str, list[Row], list[int]]:
    """The letters before OFF, and the rows from the counts on, which may stand right behind it."""
    if not rows:
        raise ValueError("it holds nothing but comments")
    match = re.fullmatch(r"((?:ST)?[CN]{0,2})(4?n?)OFF(\d*)", rows[0][0])
    if not match:
        if len(rows[0]) == 3 and all(word.isdigit() for word in rows[0]):
            return "", rows, lines  # the word may be left out
        raise ValueError(f"expected OFF in its first line, got {rows[0][0][:30]!r}")
    if match[2]:
        raise ValueError(f"{rows[0][0]} has other than three coordinates: expected OFF")
    rest = ([match[3]] if match[3] else []) + rows[0][1:]
    return match[1], ([rest] if rest else []) + rows[1:], (lines[:1] if rest else []) + lines[1:]


def _unwrapped(body: list[Row], V: int, F: int, kind: str) -> list[Row]:
    """Rows of vertices and faces out of lines that are broken elsewhere: then there can be no colours."""
    words = [word for row in body for word in row]
    there = (
        f"it announces {V:,} vertices and {F:,} faces, {min(V, len(body)):,} and {max(0, len(body) - V):,} are there"
    )
    if kind or len(words) < 3 * V:
        raise ValueError(there)
    rows, at = [words[3 * i : 3 * i + 3] for i in range(V)], 3 * V
    for _ in range(F):
        if at >= len(words) or not words[at].isdigit():
            raise ValueError(there)
        end = at + 1 + whole(words[at])
        rows.append(words[at:end])
        at = end
    if at != len(words):
        raise ValueError(there)
    return rows


def _vertices(
    rows: list[Row], kind: str, numbers: Numbers, lines: list[int] | None
) -> tuple[np.ndarray, tuple[str, ...]]:
    table = []
    for i, row in enumerate(rows):
        try:
            table.append(numbers.floats(row))
            if len(row) < 3 or len(row) != len(rows[0]):
                raise ValueError
        except ValueError:
            raise _BadRow(row, lines[i] if lines else None) from None
    table = np.array(table, dtype=np.float64).reshape(len(rows), -1)
    if not len(rows):
        return np.empty((0, 3)), ()
    rest = table.shape[1] - 3 - 3 * ("N" in kind) - 2 * ("ST" in kind)
    if rest == 0 or ("C" in kind and rest in (3, 4)):
        return table[:, :3], ()
    if kind or rest < 3:
        raise ValueError(f"{kind}OFF with {table.shape[1]} numbers a vertex: what they are cannot be told")
    return table[:, :3], (f"columns behind x y z taken for {extras(table[:, 3:])}, left out",)


def _faces(rows: list[Row], lines: list[int] | None) -> tuple[np.ndarray, np.ndarray]:
    """The corners of all faces, and how many each has; behind them may be 1, 3 or 4 numbers of a colour."""
    corners, counts = [], []
    for i, row in enumerate(rows):
        try:
            n = whole(row[0])
            if n < 0 or len(row) - 1 - n not in (0, 1, 3, 4):
                raise ValueError
            corners.extend(whole(word) for word in row[1 : n + 1])
            [float(word.replace(",", ".")) for word in row[n + 1 :]]
            counts.append(n)
        except ValueError:
            raise _BadRow(row, lines[i] if lines else None) from None
    return np.array(corners, dtype=np.int64), np.array(counts, dtype=np.int64)
