"""Legacy VTK, text and binary, versions 1 to 5.1: of its datasets PolyData, and of that the surface."""

import re

import numpy as np

from lssd_learn.shapes.reading.parsed import Parsed, some
from lssd_learn.shapes.reading.polydata import POINTS_ALONE, Cells, surface
from lssd_learn.shapes.reading.words import Numbers, text_of, whole

# Binary numbers are big-endian. A long has eight bytes where it was written in the last twenty years.
_TYPES = {
    "unsigned_char": ">u1", "char": ">i1", "unsigned_short": ">u2", "short": ">i2", "unsigned_int": ">u4", "int": ">i4",
    "unsigned_long": ">u8", "long": ">i8", "vtkidtype": ">i4", "vtktypeint64": ">i8", "vtktypeuint64": ">u8",
    "vtktypeint32": ">i4", "float": ">f4", "double": ">f8",
}  # fmt: skip
_CELLS = {"vertices", "lines", "polygons", "triangle_strips"}


def read(data: bytes) -> Parsed:
    """Vertices and faces in the order of the file; triangle strips come behind the polygons.

    Raises:
        ValueError: another dataset than PolyData, a section that does not fit, less than it announces.
    """
    data = data.removeprefix(b"\xef\xbb\xbf")
    head = data[:4096].split(b"\n", 3)
    if len(head) < 4 or not head[0].startswith(b"# vtk DataFile Version"):
        raise ValueError("expected # vtk DataFile Version in its first line")
    kind = head[2].strip().lower()
    if kind not in (b"ascii", b"binary"):
        raise ValueError(f"expected ASCII or BINARY in its third line, got {head[2][:30]!r}")
    if kind == b"ascii":
        data = text_of(data).encode()
    body = _Body(data, sum(len(line) + 1 for line in data.split(b"\n", 3)[:3]), kind == b"binary")
    words = body.line()
    if [word.lower() for word in words] != ["dataset", "polydata"]:
        raise ValueError(f"expected DATASET POLYDATA, got {' '.join(words)[:60] or 'nothing'!r}")
    vertices, cells = None, {}
    while words := body.line():
        key = words[0].lower()
        if key in ("cell_data", "point_data"):
            break  # values at the vertices, and nothing else any more
        if key == "field":
            body.skip_field(words)
        elif key == "metadata":
            body.skip_metadata()
        elif key == "points" and len(words) == 3 and vertices is None:
            vertices = body.numbers(3 * whole(words[1]), words[2]).astype(np.float64).reshape(-1, 3)
        elif key in _CELLS and len(words) == 3 and key not in cells:
            cells[key] = body.cells(whole(words[1]), whole(words[2]))
        else:
            raise ValueError(f"it has a line {' '.join(words)[:60]!r}, which is none of PolyData")
    if vertices is None:
        raise ValueError("it has no POINTS")
    none = Cells.none()
    lines = cells.get("lines", none)
    notes = (f"left out {some(len(lines.counts), 'line')}",) if len(lines.counts) else ()
    notes = notes if cells else (POINTS_ALONE,)
    return surface(
        vertices, cells.get("polygons", none), cells.get("triangle_strips", none), (*notes, *body.texts.notes)
    )


class _Body:
    """What stands behind the three lines of a header, read from a place on.

    Args:
        data: the file; of a text with ends of line that are one byte.
        at: the place.
        binary: whether numbers are.
    """

    def __init__(self, data: bytes, at: int, binary: bool):
        self.data, self.at, self.binary = data, at, binary
        self.texts = Numbers()

    def line(self) -> list[str]:
        """The words of the next line that has any; none at the end."""
        while self.at < len(self.data):
            stop = self.data.find(b"\n", self.at)
            stop = len(self.data) if stop < 0 else stop
            line = self.data[self.at : min(stop, self.at + 500)]
            self.at = stop + 1
            if words := line.decode("utf-8", errors="replace").split():
                return words
        return []

    def numbers(self, count: int, kind: str) -> np.ndarray:
        """(count,) of a type."""
        code = _TYPES.get(kind.lower())
        if code is None or count < 0:
            raise ValueError(f"expected numbers of {', '.join(_TYPES)}, got {count} of {kind[:30]!r}")
        if not self.binary:
            return self._text(count, code[1] == "f")
        size = int(code[2])
        there = (len(self.data) - self.at) // size
        if count > there:
            raise ValueError(f"it announces {count:,} numbers, {max(0, there):,} are there")
        found = np.frombuffer(self.data, code, count, self.at)
        self.at += count * size
        return found.astype(code[1:])

    def _text(self, count: int, real: bool) -> np.ndarray:
        words: list[str] = []
        while len(words) < count:
            stop = self.data.find(b"\n", self.at)
            stop = len(self.data) if stop < 0 else stop
            if self.at >= len(self.data):
                raise ValueError(f"it announces {count:,} numbers, {len(words):,} are there")
            words += self.data[self.at : stop].decode("utf-8", errors="replace").split()
            self.at = stop + 1
        if len(words) > count:
            raise ValueError(f"it announces {count:,} numbers, a line goes on with {words[count][:30]!r}")
        if real:
            return np.array(self.texts.floats(words), dtype=np.float64)
        try:
            return np.array([int(word) for word in words], dtype=np.int64)
        except (ValueError, OverflowError):
            raise ValueError("expected whole numbers, some are not") from None

    def cells(self, n: int, size: int) -> Cells:
        """Cells as files have had them since version 5, offsets and corners, or before, each with its number first."""
        after = re.compile(rb"\s*OFFSETS\s+(\w+)[^\n]*\n", re.IGNORECASE).match(self.data, self.at)
        if not after:
            return _counted(self.numbers(size, "int").astype(np.int64), n)
        self.at = after.end()
        offsets = self.numbers(n, after[1].decode()).astype(np.int64)
        words = self.line()
        if len(words) != 2 or words[0].lower() != "connectivity":
            raise ValueError(f"expected CONNECTIVITY, got {' '.join(words)[:60]!r}")
        return Cells.of_offsets(self.numbers(size, words[1]).astype(np.int64), offsets)

    def skip_field(self, words: list[str]) -> None:
        """Over the arrays of a field: name, components, tuples, type, and values."""
        for _ in range(whole(words[-1]) if len(words) == 3 else 0):
            words = self.line()
            while words and words[0].lower() == "metadata":
                self.skip_metadata()
                words = self.line()
            if len(words) != 4:
                raise ValueError(f"expected an array of a field, got {' '.join(words)[:60]!r}")
            count = whole(words[1]) * whole(words[2])
            if words[3].lower() not in ("string", "utf8_string"):
                self.numbers(count, words[3])
            else:
                for _ in range(count):
                    self._skip_string()

    def _skip_string(self) -> None:
        """Over a line, or in a binary file over as many bytes as the two first bits of its length say how to read."""
        if self.binary and self.at < len(self.data):
            width = 8 >> (self.data[self.at] >> 6)
            length = int.from_bytes(self.data[self.at : self.at + width], "big") & ((1 << (8 * width - 2)) - 1)
            self.at += width + length
            return
        stop = self.data.find(b"\n", self.at)
        if stop < 0:
            raise ValueError("it ends within a field")
        self.at = stop + 1

    def skip_metadata(self) -> None:
        """Over what is said of an array, up to an empty line."""
        stop = re.compile(rb"\n[ \t\r]*\n").search(self.data, self.at)
        self.at = stop.end() if stop else len(self.data)


def _counted(values: np.ndarray, n: int) -> Cells:
    """Cells of a row in which each stands behind its number of corners."""
    if not 0 <= n <= len(values):
        raise ValueError(f"it announces {n:,} cells in {len(values):,} numbers")
    if n and len(values) % n == 0 and (values[:: len(values) // n] == len(values) // n - 1).all():
        width = len(values) // n
        return Cells(values.reshape(n, width)[:, 1:].ravel(), np.full(n, width - 1))
    counts, corners, at = np.zeros(n, dtype=np.int64), [values[:0]], 0
    for i in range(n):
        count = int(values[at]) if at < len(values) else -1
        if not 0 <= count < len(values) - at:
            raise ValueError(f"cell {i} of {n:,} does not fit into the {len(values):,} numbers of its section")
        counts[i] = count
        corners.append(values[at + 1 : at + 1 + count])
        at += 1 + count
    if at != len(values):
        raise ValueError(f"{n:,} cells have {at:,} numbers, {len(values):,} are announced")
    return Cells(np.concatenate(corners), counts)
