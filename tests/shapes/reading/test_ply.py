"""PLY in the forms that programs write."""

import numpy as np
import pytest

from lssd_learn.errors import InputError
from lssd_learn.shapes import load

CODES = {
    "char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4", "float": "f4",
    "double": "f8",
    "int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2", "int32": "i4", "uint32": "u4", "float32": "f4",
    "float64": "f8",
}  # fmt: skip


def body(rows, types, order, commas) -> bytes:
    """Rows of values; a type "a b" is a list with a count of type a."""
    if not order:
        lines = []
        for row in rows:
            words = []
            for value, kind in zip(row, types, strict=True):
                values = [len(value), *value] if " " in kind else [value]
                words += [f"{x:.17g}" if isinstance(x, float) else str(x) for x in values]
            lines.append(" ".join(words))
        text = "\n".join(lines) + ("\n" if lines else "")
        return (text.replace(".", ",") if commas else text).encode()
    out = bytearray()
    for row in rows:
        for value, kind in zip(row, types, strict=True):
            if " " in kind:
                count, item = kind.split()
                out += np.array(len(value), order + CODES[count]).tobytes()
                out += np.array(value, order + CODES[item]).tobytes()
            else:
                out += np.array(value, order + CODES[kind]).tobytes()
    return bytes(out)


@pytest.fixture
def write(draft):
    def make(rng):
        order = ["", "<", ">"][rng.integers(3)]
        real = str(rng.choice(["float", "double", "float32", "float64"]))
        exact = real in ("double", "float64")
        shape = draft(rng, exact)
        vertices = shape.vertices if exact else shape.vertices.astype(np.float32).astype(np.float64)
        commas = not order and rng.random() < 0.15

        beside = [
            ("nx", real, 0.5),
            ("red", "uchar", 200),
            ("quality", "float", 0.25),
            ("s", "double", 0.125),
            ("flags", "int", -7),
        ]
        properties = [(axis, real, i) for i, axis in enumerate("xyz")]
        for extra in rng.permutation(len(beside))[: rng.integers(4)]:
            properties.insert(int(rng.integers(len(properties) + 1)), beside[extra])
        if rng.random() < 0.2:
            properties = [properties[i] for i in rng.permutation(len(properties))]
        case = str.upper if rng.random() < 0.2 else str
        types = [kind for _, kind, _ in properties]
        rows = [[float(v[x]) if name in "xyz" else x for name, _, x in properties] for v in vertices]
        elements = [("vertex", [(case(name), kind) for name, kind, _ in properties], rows, types)]

        polygons = [list(p) for p in shape.polygons]
        if rng.random() < 0.2:
            polygons.insert(int(rng.integers(len(polygons))), [0, 1])
        counter = rng.choice(["uchar", "uint8", "int", "ushort", "char"])
        listed = f"{counter} {rng.choice(['int', 'uint', 'ushort', 'short', 'int32', 'uint32'])}"
        name = rng.choice(["vertex_indices", "vertex_index", "Vertex_Indices"])
        if rng.random() < 0.15 and len(polygons) == len(shape.meant):
            strips = [v for p in polygons for v in (*p, -1)]
            elements.append(("tristrips", [("vertex_indices", "int int")], [[strips]], ["int int"]))
        else:
            face = [(name, listed, None)]
            if rng.random() < 0.3:
                face.insert(int(rng.integers(2)), ("texcoord", "uchar float", [0.5, 0.5, 0.25]))
            if rng.random() < 0.3:
                face.insert(int(rng.integers(len(face) + 1)), ("material", "int", 3))
            rows = [[p if x is None else x for _, _, x in face] for p in polygons]
            elements.append(("face", [(n, t) for n, t, _ in face], rows, [t for _, t, _ in face]))
        if rng.random() < 0.3:
            elements.insert(
                int(rng.integers(3)),
                ("camera", [("view", "float"), ("ids", "uchar short")], [[0.5, [1, 2]]], ["float", "uchar short"]),
            )
        if rng.random() < 0.2:
            elements.append(("edge", [("vertex1", "int"), ("vertex2", "int")], [[0, 1], [1, 2]], ["int", "int"]))
        if rng.random() < 0.15:
            elements = elements[::-1]
        head = ["ply", f"format {({'': 'ascii', '<': 'binary_little_endian', '>': 'binary_big_endian'})[order]} 1.0"]
        for element, kinds, rows, _ in elements:
            head.append(f"element {element} {len(rows)}")
            head += [f"property {'list ' if ' ' in kind else ''}{kind} {name}" for name, kind in kinds]
        for at in rng.integers(2, len(head), size=rng.integers(3)):
            head.insert(at, rng.choice(["comment element vertex 3", "obj_info made by hand", "comment"]))
        data = "\n".join([*head, "end_header", ""]).encode()
        end = [b"\n", b"\r\n", b"\r"][rng.integers(3)] if rng.random() < 0.5 else b"\n"
        data = data.replace(b"\n", end)
        for _, _, rows, types in elements:
            part = body(rows, types, order, commas)
            data += part if order else part.replace(b"\n", end)
        if not order and rng.random() < 0.2:
            code = ["utf-8-sig", "utf-16"][rng.integers(2)]
            data = data.decode().encode(code)
        elif order and rng.random() < 0.2:
            data += [b"\n", b"\0" * 100][rng.integers(2)]
        return data, shape.expected(vertices), f"{order or 'text'} {head}"

    return make


def test_some_files(sweep, write):
    sweep(".ply", write, 12, seed=0).check(least=0.99)


@pytest.mark.slow
def test_many_files(sweep, write):
    sweep(".ply", write, 500, seed=1).check(least=0.99)


@pytest.mark.slow
def test_files_with_a_fault_are_right_or_refused(sweep, write):
    def spoil(rng):
        data, expected, name = write(rng)
        head = data.find(b"end_header") + 12
        if data[:3] != b"ply" or head < 12:
            return data, expected, name
        way = rng.integers(3)
        if way == 0:
            data = data[: int(rng.integers(head, len(data) - 2))]
        elif way == 1:
            at = int(rng.integers(head, len(data) - 20))
            data = data[:at] + data[at + int(rng.integers(1, 20)) :]
        else:
            words = data[:head].split(b"element face ")
            if len(words) == 2:
                count = int(words[1].split()[0])
                data = data.replace(b"element face %d" % count, b"element face %d" % (count - 1 - int(rng.integers(3))))
        return data, expected, f"way {way} {name}"

    tally = sweep(".ply", spoil, 200, seed=2)
    # What is cut out of the digits of one number cannot be seen, nor a comment or an edge that is gone.
    tally.wrong = [line for line in tally.wrong if "way 1 text" not in line]
    tally.check(least=0)


def ply(vertices: str, faces: str, n: int = 3, f: int = 1, real: str = "float", more: str = "") -> str:
    return (
        f"ply\nformat ascii 1.0\nelement vertex {n}\nproperty {real} x\nproperty {real} y\nproperty {real} z\n{more}"
        f"element face {f}\nproperty list uchar int vertex_indices\nend_header\n{vertices}{faces}"
    )


CORNERS = "0 0 0\n1 0 0\n0 1 0\n"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (ply(CORNERS, "3 0 1 2\n3 0 2 1\n"), "4 numbers more than it announces"),
        (ply(CORNERS, "3 0 1 2\n", f=2), "element face: row 1 is too short"),
        (ply(CORNERS, "3 0 1 3\n"), "faces: expected indices from 0 to 2"),
        (ply(CORNERS, "3 0 1 2.5\n"), "numbers that are not whole"),
        (ply(CORNERS, "3 0 1 2\n").replace("vertex_indices", "corners"), "expected one list vertex_indices"),
        (ply(CORNERS, "3 0 1 2\n").replace("float z", "float w"), "its vertices have no z"),
        (ply(CORNERS, "3 0 1 2\n").replace("float y", "float x"), "two properties of one name"),
        (ply(CORNERS, "3 0 1 2\n").replace("float y", "quarter y"), "its header has a line 'property quarter y'"),
    ],
)  # fmt: skip
def test_refused(tmp_path, text, message):
    (tmp_path / "a.ply").write_text(text)
    with pytest.raises(InputError, match=message):
        load(tmp_path / "a.ply")


def test_a_line_too_long_is_refused(tmp_path):
    text = ply("0 0 0\n1 0 0\n0 1 0 7\n", "3 0 1 2\n")
    (tmp_path / "a.ply").write_text(text)
    with pytest.raises(InputError, match="element vertex: row 2 has 4 numbers, expected 3"):
        load(tmp_path / "a.ply")


@pytest.mark.parametrize("corners", [3, 4])
def test_a_face_behind_the_last_is_no_tail(tmp_path, corners):
    """Of however many corners those before it are."""
    data = ply("", "", n=4).replace("ascii", "binary_little_endian").encode()
    data += np.eye(4, 3, dtype="<f4").tobytes() + bytes([corners]) + np.arange(corners, dtype="<i4").tobytes()
    data += b"\x03" + np.arange(3, dtype="<i4").tobytes()
    (tmp_path / "a.ply").write_bytes(data)
    with pytest.raises(InputError, match="13 bytes more than it announces"):
        load(tmp_path / "a.ply")
