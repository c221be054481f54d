"""STL in the forms that programs write: what it holds is a soup of triangles."""

import struct

import numpy as np
import pytest

from lssd_learn.errors import InputError
from lssd_learn.shapes import Mesh, clean, load


def binary(corners: np.ndarray, head: bytes = b"", attribute: int = 0) -> bytes:
    facets = [struct.pack("<12fH", 0, 0, 1, *corner.ravel(), attribute) for corner in corners.astype(np.float32)]
    return head.ljust(80, b" " if head else b"\0") + struct.pack("<I", len(corners)) + b"".join(facets)


@pytest.fixture
def write(draft, dressed, numbers):
    def make(rng):
        text = rng.random() < 0.5
        shape = draft(rng, exact=text, polygons=text)
        if not text:
            vertices = shape.vertices.astype(np.float32).astype(np.float64)
            corners = vertices[shape.polygons].astype(np.float32)
            jitter = rng.random() < 0.3
            if jitter:  # another rounding of the same vertex
                corners = np.nextafter(corners, np.where(rng.random(corners.shape) < 0.5, np.float32(9e9), corners))
            head = [b"", b"solid made by hand", b"COLOR=\xff\xff\xff\xff"][rng.integers(3)]
            data = binary(corners, head, int(rng.integers(2**16)))
            data += [b"", b"\0\0", b"ab", b"\0" * 300][rng.integers(4)] if head != b"solid made by hand" else b""
            return data, shape.expected(vertices), f"binary {head} jitter={jitter}"
        words, vertices = numbers(shape.vertices, rng)
        up = str.upper if rng.random() < 0.2 else str
        indent = rng.choice(["", "  ", "\t"])
        solids, lines = int(rng.integers(1, 4)), []
        polygons = list(shape.polygons)
        if rng.random() < 0.2:
            polygons.insert(3, [0, 0, 1])
        for part in np.array_split(np.arange(len(polygons)), solids):
            lines.append(up("solid ") + rng.choice(["", "a facet normal", "solid.stl"]))
            for p in part:
                lines += [f"{indent}facet normal 0 0 1", f"{indent}outer loop"]
                lines += [f"{indent}{indent}vertex {' '.join(words[v])}" for v in polygons[p]]
                lines += [f"{indent}endloop", f"{indent}endfacet"]
            lines.append("endsolid" + rng.choice(["", " a"]))
        lines = [up(line) for line in lines]
        return dressed("\n".join(lines) + rng.choice(["", "\n", "\n\n"]), rng), shape.expected(vertices), "text"

    return make


def test_some_files(sweep, write):
    sweep(".stl", write, 12, seed=0).check(least=0.99)


@pytest.mark.slow
def test_many_files(sweep, write):
    sweep(".stl", write, 400, seed=1).check(least=0.99)


CORNERS = np.array([[[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[1, 0, 0], [1, 1, 0], [0, 1, 0]]], dtype=float)
FACET = "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n"


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (binary(CORNERS)[:-1], "it announces 2 faces, 1 are there"),
        (binary(CORNERS) + binary(CORNERS)[84:], "100 bytes more than it announces"),
        (b"solid a\n" + FACET.encode(), "expected endsolid in its last line"),
        (b"solid a\n" + FACET.encode().replace(b"endloop\n", b"") + b"endsolid\n", "expected the end of facet 0"),
        (b"solid a\n" + FACET.encode().replace(b"vertex 1 0 0", b"vertex 1 0") + b"endsolid\n", "facet 0 has a vertex"),
        (binary(np.zeros((2, 3, 3))), "none of its 2 faces has three different corners"),
    ],
)
def test_refused(tmp_path, data, message):
    (tmp_path / "a.stl").write_bytes(data)
    with pytest.raises(InputError, match=message):
        load(tmp_path / "a.stl")


def test_bodies_that_touch_in_a_point_stay_two(tmp_path):
    (tmp_path / "a.stl").write_bytes(binary(np.concatenate([CORNERS, CORNERS + [1, 1, 0]])))
    mesh = load(tmp_path / "a.stl")
    assert len(mesh.vertices) == 8
    assert len(clean(mesh).piece_areas) == 2


def test_corners_a_step_apart_are_one_and_said(tmp_path, caplog):
    apart = CORNERS.copy()
    apart[1, 0, 0] = np.nextafter(np.float32(1), np.float32(2))
    (tmp_path / "a.stl").write_bytes(binary(apart))
    mesh = load(tmp_path / "a.stl")
    assert len(mesh.vertices) == 4
    assert isinstance(mesh, Mesh)
    assert "joined corners up to 1.2e-07 apart" in caplog.text
