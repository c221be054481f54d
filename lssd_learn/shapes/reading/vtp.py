"""VTK's XML PolyData: arrays as text, in base64, or appended raw, packed by zlib or LZMA or not."""

import base64
import binascii
import lzma
import re
import zlib
from dataclasses import dataclass
from xml.etree import ElementTree

import numpy as np

from lssd_learn.shapes.reading.parsed import Parsed, some
from lssd_learn.shapes.reading.polydata import POINTS_ALONE, Cells, surface
from lssd_learn.shapes.reading.words import SPACES, Numbers

_TYPES = {
    **{f"Int{bits}": f"i{bits // 8}" for bits in (8, 16, 32, 64)},
    **{f"UInt{bits}": f"u{bits // 8}" for bits in (8, 16, 32, 64)},
    "Float32": "f4", "Float64": "f8", "String": "i1",
}  # fmt: skip
_APPENDED = re.compile(rb"<AppendedData\b[^>]*>\s*_")
MOST, MEMORY = 2**16, 2**28  # bytes of an array of unknown length, and of what unpacks a block
_PACKED = ("vtkZLibDataCompressor", "vtkLZMADataCompressor")


def read(data: bytes) -> Parsed:
    """Vertices and faces in the order of the file, piece after piece.

    Raises:
        ValueError: other XML, another kind of data, an array that does not fit or is packed by LZ4.
    """
    begun = _APPENDED.search(data)
    head, appended = (data[: begun.start()] + b"</VTKFile>", data[begun.end() :]) if begun else (data, b"")
    if b"<!DOCTYPE" in head or b"<!ENTITY" in head:
        raise ValueError("expected VTK's XML, which declares nothing")
    try:
        root = ElementTree.fromstring(head)
    except ElementTree.ParseError as error:
        raise ValueError(f"its XML is broken: {error}") from None
    if root.tag != "VTKFile" or root.get("type") != "PolyData":
        raise ValueError(f"expected a VTKFile of type PolyData, got {root.tag[:30]} of type {root.get('type')}")
    packed = root.get("compressor")
    if packed is not None and packed not in _PACKED:
        raise ValueError(f"its arrays are packed by {packed[:40]}: expected zlib, LZMA, or none")
    raw = begun is not None and b"raw" in data[begun.start() : begun.end()]
    order = ">" if root.get("byte_order") == "BigEndian" else "<"
    arrays = _Arrays(order, order + ("u8" if root.get("header_type") == "UInt64" else "u4"), packed, appended, raw)
    vertices, polygons, strips, lines, cells = [np.empty((0, 3))], [Cells.none()], [Cells.none()], 0, 0
    for piece in root.iterfind("./PolyData/Piece"):
        first, n = sum(map(len, vertices)), _number(piece, "NumberOfPoints")
        points = piece.find("./Points/DataArray")
        if n and points is None:
            raise ValueError("it has no points")
        vertices.append(arrays.values(points, 3 * n).astype(np.float64).reshape(n, 3) if n else np.empty((0, 3)))
        polygons.append(_cells(piece, "Polys", first, arrays))
        strips.append(_cells(piece, "Strips", first, arrays))
        lines += _number(piece, "NumberOfLines")
        cells += sum(_number(piece, f"NumberOf{kind}") for kind in ("Verts", "Lines", "Strips", "Polys"))
    notes = (f"left out {some(lines, 'line')}",) if lines else ()
    notes = notes if cells else (POINTS_ALONE,)
    said = root.find("./PolyData/FieldData/Array[@Name='SPACE']")
    space = "" if said is None else bytes(arrays.values(said).astype(np.uint8)).decode("latin-1").strip("\0 ")
    return surface(
        np.concatenate(vertices),
        _joined(polygons),
        _joined(strips),
        (*notes, *arrays.texts.notes),
        space if space in SPACES else "",
    )


def _number(piece: ElementTree.Element, name: str) -> int:
    text = (piece.get(name) or "0").strip()
    if not re.fullmatch(r"\d{1,15}", text):
        raise ValueError(f"expected a number in {name}, got {text[:30]!r}")
    return int(text)


def _joined(cells: list[Cells]) -> Cells:
    return Cells(np.concatenate([c.corners for c in cells]), np.concatenate([c.counts for c in cells]))


def _cells(piece: ElementTree.Element, kind: str, first: int, arrays: "_Arrays") -> Cells:
    """The cells of one kind of a piece, whose first vertex has number `first`."""
    n = _number(piece, f"NumberOf{kind}")
    if not n:
        return Cells.none()
    ends = arrays.values(piece.find(f"./{kind}/DataArray[@Name='offsets']"), n).astype(np.int64)
    corners = arrays.values(piece.find(f"./{kind}/DataArray[@Name='connectivity']"), int(ends[-1])).astype(np.int64)
    own = _number(piece, "NumberOfPoints")
    if len(corners) and not 0 <= corners.min() <= corners.max() < own:
        raise ValueError(f"faces: expected indices from 0 to {own - 1}, got {corners.min()} to {corners.max()}")
    return Cells.of_offsets(corners + first, np.concatenate([[0], ends]))


@dataclass(eq=False)
class _Arrays:
    """The values of data arrays, wherever in the file they are.

    Attributes:
        order: of bytes.
        header: type of the numbers before a block of bytes.
        packed: by what; None if not.
        appended: what stands behind the mark of the appended data.
        raw: whether that is bytes, not base64.
    """

    order: str
    header: str
    packed: str | None
    appended: bytes
    raw: bool

    def __post_init__(self):
        self.texts = Numbers()

    def values(self, array: ElementTree.Element | None, count: int | None = None) -> np.ndarray:
        """(count,) of an array; None is as many as it has.

        Raises:
            ValueError: other than so many, an unknown type or form, bytes that are damaged.
        """
        if array is None:
            raise ValueError("an array is missing")
        name, kind, form = array.get("Name", "")[:30], array.get("type", ""), array.get("format", "ascii")
        if kind not in _TYPES:
            raise ValueError(f"array {name}: expected a type of VTK, got {kind[:30]!r}")
        try:
            if form == "ascii":
                words = (array.text or "").split()
                found = np.array(self.texts.floats(words) if kind[0] == "F" else [int(word) for word in words])
            elif form in ("binary", "appended"):
                data, raw = self._place(array, form)
                due = None if count is None else count * int(_TYPES[kind][1])
                found = np.frombuffer(self._bytes(data, raw, due), self.order + _TYPES[kind])
            else:
                raise ValueError(f"expected ascii, binary or appended, got {form[:30]!r}")
        except (ValueError, OverflowError, zlib.error, lzma.LZMAError, binascii.Error) as error:
            raise ValueError(f"array {name}: {error}") from None
        if count is not None and len(found) != count:
            raise ValueError(f"array {name}: expected {count:,} numbers, got {len(found):,}")
        return found

    def _place(self, array: ElementTree.Element, form: str) -> tuple[bytes, bool]:
        """What begins with the values of an array, and whether it is raw."""
        if form == "binary":
            return "".join((array.text or "").split()).encode(), False
        offset = int(array.get("offset", "").strip())
        if not 0 <= offset < len(self.appended):
            raise ValueError("its place is behind the end of the file")
        return self.appended[offset:], self.raw

    def _bytes(self, data: bytes, raw: bool, due: int | None) -> bytes:
        """The values of an array from the numbers before them on; so many bytes, or `MOST` at most."""
        width = int(self.header[2])
        if self.packed is None:
            (length,) = self._numbers(_cut(data, 0, width, raw), 1)
            return _cut(data, 0, width + length, raw)[width:]
        blocks, size, last = self._numbers(_cut(data, 0, 3 * width, raw), 3)
        sizes = self._numbers(_cut(data, 0, (3 + blocks) * width, raw)[3 * width :], blocks)
        begin = (3 + blocks) * width if raw else _encoded((3 + blocks) * width)
        content = _cut(data, begin, sum(sizes), raw)
        dues = [size] * blocks
        dues[-1:] = [last or size] * min(blocks, 1)
        if sum(dues) != due if due is not None else sum(dues) > MOST:
            raise ValueError(f"expected {MOST if due is None else due:,} bytes, it announces {sum(dues):,}")
        parts, at = [], 0
        for packed, due in zip(sizes, dues, strict=True):
            parts.append(_unpacked(content[at : at + packed], due, self.packed))
            at += packed
        return b"".join(parts)

    def _numbers(self, data: bytes, count: int) -> list[int]:
        return np.frombuffer(data, self.header, count).tolist()


def _encoded(length: int) -> int:
    """How many characters of base64 so many bytes are."""
    return -(-length // 3) * 4


def _cut(data: bytes, begin: int, length: int, raw: bool) -> bytes:
    """Bytes from a place on, which is counted in characters of base64 unless they are raw."""
    due = length if raw else _encoded(length)
    part = data[begin : begin + due]
    if len(part) < due:
        raise ValueError(f"expected {due:,} bytes, {len(part):,} are there")
    return part if raw else base64.b64decode(part, validate=True)[:length]


def _unpacked(data: bytes, due: int, packed: str) -> bytes:
    """A block, never more than is due: a hostile one might be as large as it likes."""
    unpacker = zlib.decompressobj() if packed == _PACKED[0] else lzma.LZMADecompressor(memlimit=MEMORY)
    found = unpacker.decompress(data, due + 1)
    if len(found) != due:
        raise ValueError(f"a block has {'more' if len(found) > due else 'less'} than the {due:,} bytes it announces")
    return found
