"""Legacy VTK and VTK's XML, in the forms that programs write; and files that VTK itself wrote."""

import base64
import lzma
import struct
import zipfile
import zlib
from pathlib import Path
from xml.sax.saxutils import quoteattr

import numpy as np
import pytest

from lssd_learn.errors import InputError
from lssd_learn.shapes import Mesh, PointCloud, load, read, save
from lssd_learn.shapes.writing import ply, vtp

WRITTEN = Path(__file__).parent / "written_by_vtk.zip"  # by VTK 9.7, with the script in it
TRIANGLES = [[0, 3, 2], [0, 2, 1], [0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]]  # of a quad and four triangles
STRIP = [[1, 5, 2], [2, 5, 6]]


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    folder = tmp_path_factory.mktemp("written")
    with zipfile.ZipFile(WRITTEN) as archive:
        archive.extractall(folder)
    return sorted([*folder.glob("*.vtk"), *folder.glob("*.vtp")])


def test_what_vtk_writes_is_read(written):
    """Text and binary, 4.2 and 5.1; XML as text, inline and appended, raw and base64, of both orders, packed or not."""
    assert len(written) == 24
    for path in written:
        found = read(path)
        full = path.name.startswith("full")  # with a strip, a line, values, and the coordinate system of Slicer
        assert found.shape.faces.tolist() == TRIANGLES + (STRIP if full else []), path.name
        np.testing.assert_array_equal(found.shape.vertices[[4, 8]], [[0.5, 0.5, 1.25], [3, 1, 0]])
        assert found.notes == (("left out 1 line",) if full else ()), path.name
        assert found.space == ("RAS" if path.suffix == ".vtk" else "LPS" if full else ""), path.name


# What is written here, in a hand of its own.


def legacy(vertices, polygons, strips, rng) -> bytes:
    binary, old, kind = rng.random() < 0.5, rng.random() < 0.5, str(rng.choice(["float", "double"]))
    code = {"float": ">f4", "double": ">f8", "int": ">i4", "vtktypeint64": ">i8"}

    def put(values, kind):
        values = np.asarray(values).ravel()
        if binary:
            return values.astype(code[kind]).tobytes() + b"\n"
        per = int(rng.integers(1, 12))
        words = [f"{x:.17g}" if kind in ("float", "double") else str(x) for x in values.tolist()]
        return ("\n".join(" ".join(words[i : i + per]) for i in range(0, len(words), per)) + "\n").encode()

    def cells(key, cells):
        corners = [corner for cell in cells for corner in cell]
        if old:
            rows = [x for cell in cells for x in (len(cell), *cell)]
            return f"{key} {len(cells)} {len(rows)}\n".encode() + put(rows, "int")
        ends = np.cumsum([0, *map(len, cells)])
        head = f"{key} {len(ends)} {len(corners)}\nOFFSETS vtktypeint64\n".encode()
        return head + put(ends, "vtktypeint64") + b"CONNECTIVITY vtktypeint64\n" + put(corners, "vtktypeint64")

    parts = [f"# vtk DataFile Version {'3.0' if old else '5.1'}\nbones\n{'BINARY' if binary else 'ASCII'}\n".encode()]
    parts.append(b"DATASET POLYDATA\n")
    if rng.random() < 0.3:
        parts.append(b"FIELD FieldData 2\nTIME 1 1 double\n" + put([0.5], "double") + b"WHO 1 1 string\n")
        parts.append(b"\xc3a b\n" if binary else b"a b\n")
    parts.append(f"POINTS {len(vertices)} {kind}\n".encode() + put(vertices, kind))
    if rng.random() < 0.3:
        parts.append(b"METADATA\nINFORMATION 1\nNAME L2_NORM_RANGE LOCATION vtkDataArray\nDATA 2 0 3\n\n")
    if rng.random() < 0.3:
        parts.append(cells("LINES", [[0, 1], [1, 2, 3]]))
    parts += [cells("POLYGONS", polygons)] if polygons else []
    parts += [cells("TRIANGLE_STRIPS", strips)] if strips else []
    parts.append(
        f"POINT_DATA {len(vertices)}\nSCALARS a float\nLOOKUP_TABLE default\n".encode() + b"0 " * len(vertices)
    )
    return b"".join(parts)


def xml(vertices, polygons, strips, rng) -> bytes:
    kind, order = str(rng.choice(["Float32", "Float64"])), str(rng.choice(["<", ">"]))
    header, form = str(rng.choice(["u4", "u8"])), str(rng.choice(["ascii", "binary", "appended"]))
    packed, raw = str(rng.choice(["", "ZLib", "LZMA"])), rng.random() < 0.5
    code = {"Float32": "f4", "Float64": "f8", "Int64": "i8", "Int32": "i4"}
    appended = bytearray()

    def words(*values):
        return b"".join(struct.pack(order + ("I" if header == "u4" else "Q"), value) for value in values)

    def block(data, raw):
        coded = bytes if raw else base64.b64encode
        if not packed:
            return coded(words(len(data)) + data)
        pack = zlib.compress if packed == "ZLib" else lzma.compress
        size = int(rng.integers(8, 4000))
        blocks = [data[i : i + size] for i in range(0, len(data), size)]
        small = [pack(part) for part in blocks]
        rest = len(data) % size
        return coded(words(len(blocks), size, rest, *map(len, small))) + coded(b"".join(small))

    def array(name, kind, values, more=""):
        values = np.asarray(values)
        data, place, text = values.ravel().astype(order + code[kind]).tobytes(), "", ""
        if form == "ascii":
            text = " ".join(f"{x:.17g}" if kind[0] == "F" else str(x) for x in values.ravel().tolist())
        elif form == "binary":
            text = "\n   " + block(data, False).decode() + "\n"
        else:
            place = f' offset="{len(appended)}"'
            appended.extend(block(data, raw))
        return (
            f"<DataArray type={quoteattr(kind)} Name={quoteattr(name)}{more} format='{form}'{place}>{text}</DataArray>"
        )

    def cells(key, cells):
        if not cells:
            return f"<{key}/>"
        corners, ends = [corner for cell in cells for corner in cell], np.cumsum(list(map(len, cells)))
        return f"<{key}>{array('connectivity', 'Int32', corners)}{array('offsets', 'Int64', ends)}</{key}>"

    def piece(polygons, strips):
        points = array("Points", kind, vertices, " NumberOfComponents='3'")
        return (
            f"<Piece NumberOfPoints='{len(vertices)}' NumberOfPolys='{len(polygons)}' NumberOfStrips='{len(strips)}'>"
            f"<Points>{points}</Points>"
            f"{cells('Strips', strips)}{cells('Polys', polygons)}</Piece>"
        )

    half = len(polygons) // 2 if rng.random() < 0.3 else 0
    pieces = [piece(polygons[:half], []), piece(polygons[half:], strips)] if half else [piece(polygons, strips)]
    compressor = f" compressor='vtk{packed}DataCompressor'" if packed else ""
    head = f" byte_order='{'BigEndian' if order == '>' else 'LittleEndian'}' header_type='UInt{8 * int(header[1])}'"
    tail = f"<AppendedData encoding='{'raw' if raw else 'base64'}'>\n  _".encode() + appended + b"\n</AppendedData>"
    return (
        rng.choice(["", "<?xml version='1.0'?>\n"])
        + f"<VTKFile type='PolyData' version='1.0'{head}{compressor}><PolyData>{''.join(pieces)}</PolyData>"
    ).encode() + (tail if form == "appended" else b"") + b"\n</VTKFile>\n"  # fmt: skip


@pytest.fixture(params=[legacy, xml])
def write(request, draft):
    """A function: rng → a file, and an OFF that says the same."""

    def make(rng):
        shape = draft(rng, exact=True)
        vertices = shape.vertices.astype(np.float32).astype(np.float64)  # in whichever type they are written
        polygons, strips = [list(p) for p in shape.polygons], [list(p) for p in shape.polygons if len(p) == 3][:4]
        off = [
            f"OFF\n{len(vertices)} {len(polygons) + len(strips)} 0",
            *(f"{x:.9g} {y:.9g} {z:.9g}" for x, y, z in vertices),
        ]
        off += [" ".join(map(str, [len(p), *p])) for p in polygons + strips]
        return request.param(vertices, polygons, strips, rng), "\n".join(off)

    return make


def compare(write, path, n, seed):
    for i in range(n):
        data, off = write(np.random.default_rng([seed, i]))
        path.write_bytes(data)
        path.with_suffix(".off").write_text(off)
        found, known = load(path), load(path.with_suffix(".off"))
        # Of two pieces each has its own vertices: faces are told by their corners' places.
        corners, expected = (mesh.vertices[mesh.faces] for mesh in (found, known))
        np.testing.assert_allclose(corners, expected, rtol=1e-7, err_msg=str(i))


def test_some_files(tmp_path, write):
    compare(write, tmp_path / "a.vtk", 12, seed=0)


@pytest.mark.slow
def test_many_files(tmp_path, write):
    compare(write, tmp_path / "a.vtp", 500, seed=1)


SQUARE = "# vtk DataFile Version 3.0\na\nASCII\nDATASET POLYDATA\nPOINTS 4 float\n0 0 0 1 0 0\n1 1 0 0 1 0\n"


def test_a_cloud_a_square_and_other_hands(tmp_path):
    path = tmp_path / "a.vtk"
    path.write_text(SQUARE + "VERTICES 4 8\n1 0\n1 1\n1 2\n1 3\n")
    assert isinstance(load(path), PointCloud)
    assert read(path).notes == ()
    path.write_text(SQUARE)
    assert read(path).notes == ("no cells in it, not even of its points, which are taken as a cloud",)
    path.write_bytes((SQUARE + "POLYGONS 1 5\n4 0 1 2 3\n").replace("\n", "\r\n").encode())
    assert load(path).area == 1
    path.write_text(SQUARE.replace("1 1 0", "1,0 1 0") + "polygons 1 5\n4 0 1 2 3\n")
    assert read(path).notes == ("decimal commas taken for points",)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (SQUARE.replace("POLYDATA", "UNSTRUCTURED_GRID"), "expected DATASET POLYDATA, got 'DATASET UNSTRUCTURED_GRID'"),
        (SQUARE.replace("ASCII", "TEXT"), "expected ASCII or BINARY in its third line, got b'TEXT'"),
        (SQUARE + "POLYGONS 1 5\n4 0 1 2\n", "it announces 5 numbers, 4 are there"),
        (SQUARE + "POLYGONS 1 5\n4 0 1 2 3 4\n", "it announces 5 numbers, a line goes on with '4'"),
        (SQUARE + "POLYGONS 2 5\n4 0 1 2 3\n", "2 cells.* 5 numbers|cell 1 of 2 does not fit"),
        (SQUARE + "POLYGONS 1 5\n4 0 1 2 9\n", "faces: expected indices from 0 to 3, got some from 0 to 9"),
        (SQUARE + "POLYGONS 1 5\n4 0 1 2.5 3\n", "expected whole numbers, some are not"),
        (SQUARE + "CELLS 1 5\n4 0 1 2 3\n", "it has a line 'CELLS 1 5', which is none of PolyData"),
        (SQUARE + "POLYGONS 2 4\nOFFSETS vtktypeint64\n0 3\nCONNECTIVITY int\n0 1 2 3\n", "offsets of cells: expected"),
        (
            SQUARE.replace("1 1 0", "1.5 1,5 0") + "POLYGONS 1 5\n4 0 1 2 3\n",
            "could not convert string to float: '1,5'",
        ),
        (SQUARE.split("POINTS")[0], "it has no POINTS"),
        (
            "<VTKFile type='UnstructuredGrid'></VTKFile>",
            "expected a VTKFile of type PolyData, got VTKFile of type Unst",
        ),
        ("<VTKFile type='PolyData'>", "its XML is broken"),
        ("<!DOCTYPE a [<!ENTITY b 'c'>]><VTKFile type='PolyData'></VTKFile>", "VTK's XML, which declares nothing"),
        (
            "<VTKFile type='PolyData' compressor='vtkLZ4DataCompressor'></VTKFile>",
            "packed by vtkLZ4DataCompressor: exp",
        ),
        ("<html><body>VTKFile</body></html>", "it is XML or a web page"),
    ],
)
def test_refused(tmp_path, text, message):
    (tmp_path / "a.vtk").write_text(text)
    with pytest.raises(InputError, match=f"a.vtk: expected VTK, .*{message}"):
        load(tmp_path / "a.vtk")


def test_an_array_that_is_packed_too_well_is_refused(tmp_path):
    """A block that says it is small, and one that says it is as large as can be."""
    mesh = Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    plain = vtp(mesh).decode()
    content = plain.split('format="binary">')[1].split("<")[0]
    bomb = zlib.compress(b"\0" * 10**6)
    for size in (72, 10**6, 2**62):
        packed = base64.b64encode(struct.pack("<4Q", 1, size, 0, len(bomb))) + base64.b64encode(bomb)
        text = plain.replace(content, packed.decode()).replace(
            'PolyData" v', 'PolyData" compressor="vtkZLibDataCompressor" v'
        )
        (tmp_path / "a.vtp").write_text(text)
        with pytest.raises(InputError, match="array Points: (a block has more than|expected 72 bytes)"):
            load(tmp_path / "a.vtp")


def test_the_coordinate_system_is_read_of_every_format_that_says_it(tmp_path, small_mesh):
    for suffix, says in (("ply", b"comment SPACE=RAS\n"), ("obj", b"# 3D Slicer output. SPACE=RAS\n")):
        path = tmp_path / f"a.{suffix}"
        save(small_mesh, path)
        assert read(path).space == ""
        data = path.read_bytes()
        path.write_bytes(data.replace(b"1.0\n", b"1.0\n" + says, 1) if suffix == "ply" else says + data)
        assert read(path).space == "RAS"
    save(small_mesh, tmp_path / "a.stl")
    data = (tmp_path / "a.stl").read_bytes()
    (tmp_path / "a.stl").write_bytes(b"3D Slicer output. SPACE=LPS".ljust(80, b"\0") + data[80:])
    assert read(tmp_path / "a.stl").space == "LPS"


def test_values_go_with_their_names(tmp_path, small_mesh):
    values = np.linspace(0, 1, len(small_mesh.vertices))
    (tmp_path / "a.ply").write_bytes(ply(small_mesh, values={"area region": values}))
    (tmp_path / "a.vtp").write_bytes(vtp(small_mesh, {"area <region>": values}))
    for name in ("a.ply", "a.vtp"):
        np.testing.assert_array_equal(load(tmp_path / name).vertices, small_mesh.vertices)
    head, body = (tmp_path / "a.ply").read_bytes().split(b"end_header\n")
    assert b"property double z\nproperty double area_region\n" in head
    rows = np.frombuffer(body, "<f8", 4 * len(values)).reshape(-1, 4)
    np.testing.assert_array_equal(rows[:, 3], values)
    text = (tmp_path / "a.vtp").read_text()
    data = text.split('Name="area &lt;region&gt;" format="binary">')[1].split("<")[0]
    np.testing.assert_array_equal(np.frombuffer(base64.b64decode(data)[8:], "<f8"), values)
