"""OBJ, the text format of Wavefront. Vertices keep the order of the file, whatever textures and materials do."""

import re
from collections import Counter
from collections.abc import Iterator

import numpy as np

from lssd_learn.shapes.reading.parsed import Parsed, some
from lssd_learn.shapes.reading.polygons import triangles
from lssd_learn.shapes.reading.words import Numbers, text_of, whole

# What says nothing of the surface.
_BESIDE = {
    "vt", "vn", "g", "o", "s", "mg", "usemtl", "mtllib", "usemap", "maplib", "bevel", "c_interp", "d_interp",
    "lod", "shadow_obj", "trace_obj", "call", "csh",
}  # fmt: skip
_CURVED = {
    "vp", "cstype", "deg", "bmat", "step", "curv", "curv2", "surf", "parm", "trim", "hole", "scrv", "sp",
    "end", "con", "ctech", "stech", "bzp", "bsp", "cdc", "cdp", "res",
}  # fmt: skip
_LEFT_OUT = {"l": "line", "p": "point"}


def read(data: bytes) -> Parsed:
    """Vertices and faces in the order of the file.

    Raises:
        ValueError: a line that cannot be understood, with its number; curved surfaces.
    """
    vertices, corners, counts = [], [], []
    numbers, left_out, unknown = Numbers(), Counter(), Counter()
    for number, line in _lines(text_of(data)):
        kind, *words = line.split() or [""]
        kind = kind.lower()
        try:
            if kind == "v":
                vertices.append(_vertex(numbers.floats(words)))
            elif kind in ("f", "fo"):
                corners.extend(_index(word, len(vertices)) for word in words)
                counts.append(len(words))
            elif kind in _LEFT_OUT:
                left_out[_LEFT_OUT[kind]] += 1
            elif kind in _CURVED:
                raise ValueError
            elif kind and kind not in _BESIDE:
                if not kind[0].isalpha():
                    raise ValueError
                unknown[kind] += 1
        except ValueError:
            what = "of a curved surface, which is not read" if kind in _CURVED else "no vertex or face"
            raise ValueError(f"line {number} is {what}: {line[:60]!r}") from None
    vertices = np.array(vertices, dtype=np.float64).reshape(-1, 3)
    faces, told = triangles(vertices, np.array(corners, dtype=np.int64), np.array(counts, dtype=np.int64))
    notes = [f"left out {some(count, thing)}" for thing, count in left_out.items()]
    notes += [f"left out {some(count, 'line')} that start with {word[:20]!r}" for word, count in unknown.most_common(3)]
    return Parsed(vertices, faces, (*told, *notes, *numbers.notes))


def _lines(text: str) -> Iterator[tuple[int, str]]:
    """Lines without comments, continued ones as one, with the number of the first."""
    begun, start = "", 0
    for number, line in enumerate(text.split("\n"), 1):
        statement, hash_, _ = line.partition("#")
        start = start if begun else number
        continued = re.fullmatch(r"(.*)\\\s*", statement) if not hash_ else None
        if continued:
            begun += continued[1] + " "
            continue
        yield start, begun + statement
        begun = ""
    if begun.strip():
        raise ValueError(f"line {start} goes on behind the end of the file")


def _vertex(values: list[float]) -> list[float]:
    """x y z of `x y z`, with a weight of one, with a colour, or both."""
    if len(values) not in (3, 4, 6, 7) or (len(values) == 4 and values[3] != 1):
        raise ValueError
    return values[:3]


def _index(word: str, n_vertices: int) -> int:
    """The 0-based vertex of an OBJ corner such as `7`, `7/1/2` or `-1` (the latest vertex)."""
    index = whole(word.split("/")[0])
    if index == 0 or index < -n_vertices:
        raise ValueError
    return index - 1 if index > 0 else n_vertices + index
