"""PLY, text and binary of both orders of bytes: any elements and properties; of them the surface is taken."""

import re
import struct
from dataclasses import dataclass, field

import numpy as np

from lssd_learn.shapes.reading.parsed import Parsed, some
from lssd_learn.shapes.reading.polygons import triangles, unrolled
from lssd_learn.shapes.reading.words import Numbers, tail, text_of, whole

_TYPES = {
    name: code
    for code, names in {
        "i1": "char int8", "u1": "uchar uint8", "i2": "short int16", "u2": "ushort uint16", "i4": "int int32",
        "u4": "uint uint32", "i8": "int64 longlong", "u8": "uint64 ulonglong", "f4": "float float32",
        "f8": "double float64",
    }.items()
    for name in names.split()
}  # fmt: skip
_ORDERS = {"binary_little_endian": "<", "binary_big_endian": ">", "ascii": ""}
_CORNERS = re.compile(r"vert(ex|ices)?_?ind(ex|ices|exes)")
_STRIPS = re.compile(r"tri(angle)?_?strips?")
_LEFT_OUT = {"edge": "edge", "edges": "edge"}


@dataclass(eq=False)
class _Element:
    name: str
    count: int
    properties: list[tuple[str, str, str]] = field(default_factory=list)  # name, type, type of the count if a list

    def __post_init__(self):
        if self.count < 0:
            raise ValueError(f"it announces {self.count} of element {self.name}")


def read(data: bytes) -> Parsed:
    """Vertices and faces in the order of the file; triangle strips come behind the faces.

    Raises:
        ValueError: a header that does not fit, other data than it announces.
    """
    order, elements, body = _header(data)
    numbers = Numbers()
    tables, notes = _text(body, elements, numbers) if not order else _binary(body, elements, order)
    vertices, colours, corners, counts = None, None, [], []
    strips: list[np.ndarray] = []
    for element, table in zip(elements, tables, strict=True):
        name = element.name
        if name in ("vertex", "vertices"):
            missing = [axis for axis in "xyz" if axis not in table]
            columns = [column for axis in "xyz" if isinstance(column := table.get(axis), np.ndarray)]
            if len(columns) < 3 or vertices is not None:
                raise ValueError(f"its vertices have no {' '.join(missing) or 'single x y z'}")
            vertices = np.stack([column.astype(np.float64) for column in columns], axis=1)
            colours = _colours(table)
        elif name in ("face", "faces", "polygon") or _STRIPS.fullmatch(name):
            lists = [values for key, values in table.items() if _CORNERS.fullmatch(key)]
            if element.count and (len(lists) != 1 or not isinstance(lists[0], tuple)):
                raise ValueError(
                    f"element {name}: expected one list vertex_indices, got {', '.join(table) or 'nothing'}"
                )
            if not element.count:
                continue
            values, lengths = lists[0]
            if values.dtype.kind == "f" and not (values == np.round(values)).all():
                raise ValueError("its faces name vertices by numbers that are not whole")
            values = values.astype(np.int64)
            if _STRIPS.fullmatch(name):
                strips += np.split(values, np.cumsum(lengths)[:-1])
            else:
                corners.append(values)
                counts.append(lengths)
        elif name in _LEFT_OUT and element.count:
            notes = (*notes, f"left out {some(element.count, _LEFT_OUT[name])}")
    for strip in strips:
        cut = unrolled(strip)
        corners.append(cut.ravel())
        counts.append(np.full(len(cut), 3))
    if vertices is None:
        raise ValueError("it has no element vertex")
    none = [np.empty(0, np.int64)]
    faces, told = triangles(vertices, np.concatenate(none + corners), np.concatenate(none + counts))
    return Parsed(vertices, faces, (*told, *notes, *numbers.notes), colours=colours)


def _colours(table: "_Table") -> np.ndarray | None:
    """(V, 3) of the vertices, 0 to 1: whole numbers are 0 to 255, others 0 to 1."""
    parts = [part for name in ("red", "green", "blue") if isinstance(part := table.get(name), np.ndarray)]
    if len(parts) < 3:
        return None
    return np.stack([part / (255.0 if part.dtype.kind in "iu" else 1.0) for part in parts], axis=1)


def _header(data: bytes) -> tuple[str, list[_Element], bytes]:
    """The order of bytes ("" for text), the elements, and what stands behind the header."""
    if data[:2] in (b"\xff\xfe", b"\xfe\xff"):
        data = text_of(data).encode()
    data = data.removeprefix(b"\xef\xbb\xbf").lstrip(b" \t\r\n")
    first = re.match(rb"ply[ \t]*(\r\n|\n|\r)", data)
    if not first:
        raise ValueError("expected ply in its first line")
    end, at, order, elements = (b"\r" if first[1] == b"\r" else b"\n"), first.end(), None, []
    while True:
        stop = data.find(end, at)
        if stop < 0 or stop - at > 10_000:
            raise ValueError("its header has no end")
        words = data[at:stop].decode("utf-8", errors="replace").split()
        at = stop + 1
        key = words[0].lower() if words else ""
        if key == "end_header":
            break
        if key == "format" and len(words) >= 2 and words[1].lower() in _ORDERS:
            order = _ORDERS[words[1].lower()]
        elif key == "element" and len(words) == 3:
            elements.append(_Element(words[1].lower(), whole(words[2])))
        elif key == "property" and elements:
            elements[-1].properties.append(_property(words))
        elif key and key not in ("comment", "obj_info") and not key.startswith("#"):
            raise ValueError(f"its header has a line {' '.join(words)[:60]!r}")
    if order is None:
        raise ValueError("its header tells no format")
    for element in elements:
        names = [name for name, _, _ in element.properties]
        if len(set(names)) < len(names):
            raise ValueError(f"element {element.name} has two properties of one name: {', '.join(names)}")
    return order, elements, data[at:]


def _property(words: list[str]) -> tuple[str, str, str]:
    types = [_TYPES.get(word.lower(), "") for word in words[1:-1]]
    if len(types) == 3 and words[1].lower() == "list":
        types = types[1:]
        if types[0][:1] == "f":
            types[0] = ""
    elif len(types) == 1:
        types = ["", *types]
        if types[1]:
            return words[-1].lower(), types[1], ""
    if len(types) != 2 or not all(types):
        raise ValueError(f"its header has a line {' '.join(words)[:60]!r}")
    return words[-1].lower(), types[1], types[0]


# A table: name → values (count,), or for a list all values and how many each row has.
_Table = dict[str, "np.ndarray | tuple[np.ndarray, np.ndarray]"]


def _text(body: bytes, elements: list[_Element], numbers: Numbers) -> tuple[list[_Table], tuple[str, ...]]:
    lines = [line.split() for line in text_of(body).split("\n")]
    lines = [line for line in lines if line and line[0] not in ("comment", "obj_info") and line[0][0] != "#"]
    lines = [line if "#" not in "".join(line) else " ".join(line).split("#")[0].split() for line in lines]
    announced = sum(element.count for element in elements if element.properties)
    if len(lines) != announced:  # lines broken elsewhere: the numbers still have to be just as many
        words, lines = [word for line in lines for word in line], None
        if announced > len(words):
            raise ValueError(f"it announces {announced:,} rows, {len(words):,} numbers are there")
    tables, at = [], 0
    for element in elements:
        columns: list[list] = [[] for _ in element.properties]
        lengths: list[list[int]] = [[] for _ in element.properties]
        for row in range(element.count if element.properties else 0):
            line, place = (words, at) if lines is None else (lines[at], 0)
            for (name, _, size), column, length in zip(element.properties, columns, lengths, strict=True):
                n = 1
                if size:
                    n = whole(line[place]) if place < len(line) else -1
                    length.append(n)
                    place += 1
                if n < 0 or place + n > len(line):
                    raise ValueError(f"element {element.name}: row {row} is too short for {name}")
                column.extend(line[place : place + n])
                place += n
            if lines is not None and place != len(line):
                raise ValueError(f"element {element.name}: row {row} has {len(line)} numbers, expected {place}")
            at = place if lines is None else at + 1
        table: _Table = {}
        for (name, kind, size), column, length in zip(element.properties, columns, lengths, strict=True):
            table[name] = values = _values(column, kind, numbers)
            if size:
                table[name] = values, np.array(length, dtype=np.int64)
        tables.append(table)
    if lines is None and at != len(words):
        raise ValueError(f"{len(words) - at:,} numbers more than it announces")
    return tables, ()


def _values(words: list[str], kind: str, numbers: Numbers) -> np.ndarray:
    if kind[0] == "f":
        return np.array(numbers.floats(words), dtype=np.float64)
    try:
        return np.array([int(word) for word in words], dtype=np.int64)
    except (ValueError, OverflowError):
        return np.array(numbers.floats(words), dtype=np.float64)


def _binary(body: bytes, elements: list[_Element], order: str) -> tuple[list[_Table], tuple[str, ...]]:
    tables, at, least_row = [], 0, 2
    for element in elements:
        least = sum(int((size or kind)[1]) for _, kind, size in element.properties)
        if element.count * least > len(body) - at:
            there = max(0, len(body) - at) // least
            raise ValueError(f"it announces {element.count:,} of element {element.name}, {there:,} are there")
        table, at = _rows(body, at, element, order)
        if element.count and element.properties:
            least_row = max(2, _least_row(element))
        tables.append(table)
    return tables, tail(body[at:], least_row)


def _least_row(element: _Element) -> int:
    """The bytes of the shortest row that would change the surface: a triangle, and no other list has anything."""
    return sum(
        int((size or kind)[1]) + (3 * int(kind[1]) if size and _CORNERS.fullmatch(name) else 0)
        for name, kind, size in element.properties
    )


def _rows(body: bytes, at: int, element: _Element, order: str) -> tuple[_Table, int]:
    """All rows of an element from a place on, and where the next begins."""
    if not element.count or not element.properties:
        return {name: _nothing(size) for name, _, size in element.properties}, at
    found = _even(body, at, element, order)
    if found:
        return found
    codes = dict(
        zip(["i1", "u1", "i2", "u2", "i4", "u4", "i8", "u8", "f4", "f8"], "bBhHiIqQfd", strict=True)
    )  # for struct
    columns: list[list] = [[] for _ in element.properties]
    lengths: list[list[int]] = [[] for _ in element.properties]
    kinds = [
        (codes[kind], int(kind[1]), struct.Struct(order + codes[size]) if size else None)
        for _, kind, size in element.properties
    ]
    try:
        for _ in range(element.count):
            for (code, width, counter), column, length in zip(kinds, columns, lengths, strict=True):
                n = 1
                if counter:
                    (n,) = counter.unpack_from(body, at)
                    at += counter.size
                    if n < 0 or n * width > len(body) - at:
                        raise struct.error
                    length.append(n)
                column.extend(struct.unpack_from(f"{order}{n}{code}", body, at))
                at += n * width
    except struct.error:
        there = len(lengths[0] or columns[0])
        raise ValueError(
            f"it announces {element.count:,} of element {element.name}, about {there:,} are there"
        ) from None
    table: _Table = {}
    for (name, kind, size), column, length in zip(element.properties, columns, lengths, strict=True):
        values = np.array(column, dtype=kind)
        table[name] = (values, np.array(length, dtype=np.int64)) if size else values
    return table, at


def _nothing(size: str):
    return (np.empty(0, np.int64), np.empty(0, np.int64)) if size else np.empty(0)


def _even(body: bytes, at: int, element: _Element, order: str) -> tuple[_Table, int] | None:
    """As `_rows`, at once, if every list is as long as that of the first row; else None."""
    fields, place = [], at
    for i, (_, kind, size) in enumerate(element.properties):
        n = 1
        if size:
            n = int.from_bytes(
                body[place : place + int(size[1])], "little" if order == "<" else "big", signed=size[0] == "i"
            )
            fields.append((f"n{i}", order + size))
            place += int(size[1])
            if not 0 <= n <= len(body) // int(kind[1]):
                return None
        fields.append((f"v{i}", order + kind, (n,)))
        place += n * int(kind[1])
    kind = np.dtype(fields)
    if kind.itemsize * element.count > len(body) - at:
        return None
    rows = np.frombuffer(body, kind, element.count, at)
    table: _Table = {}
    for i, (name, _, size) in enumerate(element.properties):
        values = rows[f"v{i}"]
        values = values.astype(values.dtype.newbyteorder("="))
        if size:
            lengths = rows[f"n{i}"].astype(np.int64)
            if (lengths != values.shape[1]).any():
                return None
            table[name] = values.ravel(), lengths
        else:
            table[name] = values[:, 0]
    return table, at + kind.itemsize * element.count
