"""STL, binary and text: triangles without vertices. Which corners are one vertex is told by their edges."""

import re

import numpy as np

from lssd_learn.shapes.mending.seams import seams
from lssd_learn.shapes.reading.parsed import Parsed, some
from lssd_learn.shapes.reading.polygons import triangles
from lssd_learn.shapes.reading.words import MARKS, Numbers, tail, text_of

_FACET = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def read(data: bytes) -> Parsed:
    """Faces in the order of the file, vertices in that of their first corner.

    Corners are one vertex where their faces share an edge: its ends at the same places or, as some programs write
    them, a step of rounding apart. Bodies that touch in a point stay two.

    Raises:
        ValueError: less than the file announces, or more; a line that does not fit.
    """
    if not _is_binary(data):
        corners, counts, notes = _text(text_of(data))
    else:
        count = int.from_bytes(data[80:84], "little")
        if len(data) < 84 + 50 * count:
            raise ValueError(f"it announces {count:,} faces, {max(0, len(data) - 84) // 50:,} are there")
        notes = tail(data[84 + 50 * count :], 50)
        corners = np.frombuffer(data, _FACET, count, 84)["corners"].astype(np.float64).reshape(-1, 3)
        counts = np.full(count, 3)
    if not np.isfinite(corners).all():
        raise ValueError("expected finite coordinates, some are not")
    faces, told = triangles(corners, np.arange(len(corners)), counts)
    proper = (corners[faces] != corners[np.roll(faces, 1, axis=1)]).any(axis=2).all(axis=1)
    if not proper.any():
        raise ValueError(f"none of its {len(counts):,} faces has three different corners")
    flat = (f"left out {some((~proper).sum(), 'face')} with two corners at one place",) if not proper.all() else ()
    into, gap = seams(corners, faces[proper])
    apart = (f"joined corners up to {gap:.2g} apart",) if gap else ()
    into = into[faces[proper]]
    kept, number = np.unique(into, return_inverse=True)
    return Parsed(corners[kept], number.reshape(-1, 3), (*notes, *told, *flat, *apart))


def _is_binary(data: bytes) -> bool:
    if len(data) >= 84 and len(data) == 84 + 50 * int.from_bytes(data[80:84], "little"):
        return True
    if data[:2] in MARKS:
        return False
    return b"\0" in (data[:1000] if data[:5].lower() == b"solid" else data)


def _text(text: str) -> tuple[np.ndarray, np.ndarray, tuple[str, ...]]:
    """The corners of all facets, how many each has, and notes."""
    lines = [line.split("#")[0].strip() for line in text.lower().split("\n")]
    lines = [line for line in lines if line]
    if not lines or not lines[0].startswith("solid"):
        raise ValueError("expected solid in its first line, or the binary form")
    if not lines[-1].startswith("endsolid"):
        raise ValueError("expected endsolid in its last line")
    words = " ".join(line for line in lines if not re.match(r"(end)?solid\b", line)).split()
    numbers, at, corners, counts = Numbers(), 0, [], []
    while at < len(words):
        if words[at : at + 2] != ["facet", "normal"] or words[at + 5 : at + 7] != ["outer", "loop"]:
            raise ValueError(f"expected a facet, got {' '.join(words[at : at + 7])[:60]!r}")
        at, count = at + 7, 0
        while words[at : at + 1] == ["vertex"]:
            corner = words[at + 1 : at + 4]
            try:
                corners.append(numbers.floats(corner))
            except ValueError as error:
                raise ValueError(f"facet {len(counts)} has a vertex {' '.join(corner)[:60]!r}: {error}") from None
            if len(corner) < 3:
                raise ValueError("its last vertex is cut off")
            at, count = at + 4, count + 1
        if words[at : at + 2] != ["endloop", "endfacet"]:
            raise ValueError(f"expected the end of facet {len(counts)}, got {' '.join(words[at : at + 2])[:60]!r}")
        at += 2
        counts.append(count)
    return np.array(corners, dtype=np.float64).reshape(-1, 3), np.array(counts, dtype=np.int64), numbers.notes
