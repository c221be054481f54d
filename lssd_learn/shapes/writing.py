"""Shapes as bytes, for `files.save`. OFF, OBJ, XYZ, PLY, VTK and VTP keep every digit; STL and GLB hold float32.

Far from the origin float32 has no digits left for the shape. A GLB then lies about its own middle, and its node takes
it to its place; an STL, which has no such thing, is written as text. Other writers round to a fixed number of decimals.
"""

import base64
import io
import re
from collections.abc import Mapping
from typing import cast
from xml.sax.saxutils import quoteattr

import numpy as np
import trimesh
from jaxtyping import Float, UInt8

from lssd_learn.shapes.mesh import Mesh, PointCloud, Shape

FAR = 10  # times its size from the origin: a float32 then has fewer than six digits for the shape


def off(shape: Shape) -> bytes:
    """OFF; a cloud has zero faces."""
    faces = _face_array(shape)
    head = f"OFF\n{len(shape.vertices)} {len(faces)} 0\n"
    return (head + _rows(shape.vertices, "%.17g %.17g %.17g") + _rows(faces, "3 %d %d %d")).encode()


def obj(shape: Shape) -> bytes:
    """OBJ; a cloud has vertices only."""
    return (_rows(shape.vertices, "v %.17g %.17g %.17g") + _rows(_face_array(shape) + 1, "f %d %d %d")).encode()


def xyz(shape: Shape) -> bytes:
    """One line a point."""
    return _rows(shape.vertices, "%.17g %.17g %.17g").encode()


def ply(
    shape: Shape,
    colours: UInt8[np.ndarray, "V 3"] | None = None,
    values: Mapping[str, Float[np.ndarray, " V"]] | None = None,
    space: str = "",
) -> bytes:
    """Binary PLY, its coordinates float64; with a colour a vertex if given, and values as properties by their names.

    A coordinate system, "LPS" or "RAS", stands in a comment, as 3D Slicer has it.
    """
    faces = _face_array(shape)
    listed = np.empty(len(faces), dtype=[("count", "u1"), ("corners", "<i4", 3)])
    listed["count"], listed["corners"] = 3, faces
    said = f"comment SPACE={space}\n" if space else ""
    head = (
        f"ply\nformat binary_little_endian 1.0\n{said}element vertex {len(shape.vertices)}\n"
        "property double x\nproperty double y\nproperty double z\n"
    )
    columns = [shape.vertices.astype("<f8").view("u1")]
    if colours is not None:
        head += "property uchar red\nproperty uchar green\nproperty uchar blue\n"
        columns.append(colours)
    for name, value in (values or {}).items():
        head += f"property double {re.sub(r'[^A-Za-z0-9_]', '_', name)}\n"
        columns.append(value.astype("<f8")[:, None].view("u1"))
    rows = np.hstack(columns)
    if len(faces):
        head += f"element face {len(faces)}\nproperty list uchar int vertex_indices\n"
    return f"{head}end_header\n".encode() + rows.tobytes() + listed.tobytes()


def stl(shape: Shape) -> bytes:
    """Binary STL of a mesh; text, with every digit, if it lies far from the origin."""
    faces = _face_array(shape)
    if not own_origin(shape).any():
        return cast(bytes, trimesh.Trimesh(shape.vertices, faces, process=False).export(file_type="stl"))
    corners = shape.vertices[faces].reshape(-1, 9)
    facet = f"facet normal 0 0 0\nouter loop\n{3 * 'vertex %.17g %.17g %.17g@'}endloop\nendfacet".replace("@", "\n")
    return ("solid\n" + _rows(corners, facet) + "endsolid\n").encode()


def glb(shape: Shape, colours: UInt8[np.ndarray, "V 3"] | None = None) -> bytes:
    """GLB with one object, about its own middle if it lies far from the origin; with a colour a vertex if given."""
    middle = own_origin(shape)
    points = shape.vertices - middle
    if isinstance(shape, PointCloud):
        part = trimesh.PointCloud(points, colors=colours)
    else:
        part = trimesh.Trimesh(points, shape.faces, vertex_colors=colours, process=False)
    scene = trimesh.Scene()
    scene.add_geometry(part, transform=trimesh.transformations.translation_matrix(middle))
    return cast(bytes, scene.export(file_type="glb"))


def vtk(shape: Shape) -> bytes:
    """Binary legacy VTK, PolyData of version 4.2, which Slicer writes too; a cloud has a cell a point."""
    corners = shape.faces if isinstance(shape, Mesh) else np.arange(len(shape.vertices))[:, None]
    cells = np.insert(corners, 0, corners.shape[1], axis=1)
    kind = "POLYGONS" if isinstance(shape, Mesh) else "VERTICES"
    return b"".join(
        [
            b"# vtk DataFile Version 4.2\nlssd_learn\nBINARY\nDATASET POLYDATA\n",
            f"POINTS {len(shape.vertices)} double\n".encode() + shape.vertices.astype(">f8").tobytes(),
            f"\n{kind} {len(cells)} {cells.size}\n".encode() + cells.astype(">i4").tobytes() + b"\n",
        ]
    )


def vtp(shape: Shape, values: Mapping[str, np.ndarray] | None = None, space: str = "") -> bytes:
    """VTK's XML PolyData, its arrays in base64; with values (V,) or colours (V, 3) uint8 as arrays of these names.

    A coordinate system, "LPS" or "RAS", stands in the field data, as 3D Slicer has it.
    """
    corners = shape.faces if isinstance(shape, Mesh) else np.arange(len(shape.vertices))[:, None]
    kind = "Polys" if isinstance(shape, Mesh) else "Verts"
    ends = np.arange(1, len(corners) + 1) * corners.shape[1]
    letters = " ".join(str(ord(letter)) for letter in f"{space}\0")
    said = f'<Array type="String" Name="SPACE" NumberOfTuples="1" format="ascii">{letters}</Array>'
    said = f"<FieldData>\n{said}\n</FieldData>\n" if space else ""
    arrays = "".join(_array(name, value) for name, value in (values or {}).items())
    return (
        '<?xml version="1.0"?>\n'
        '<VTKFile type="PolyData" version="1.0" byte_order="LittleEndian" header_type="UInt64">\n'
        f'<PolyData>\n{said}<Piece NumberOfPoints="{len(shape.vertices)}" NumberOf{kind}="{len(corners)}">\n'
        f"<PointData>\n{arrays}</PointData>\n<Points>\n{_array('Points', shape.vertices)}</Points>\n"
        f"<{kind}>\n{_array('connectivity', corners.ravel())}{_array('offsets', ends)}</{kind}>\n"
        "</Piece>\n</PolyData>\n</VTKFile>\n"
    ).encode()


def _array(name: str, values: np.ndarray) -> str:
    kinds = {"f": ("Float64", "<f8"), "i": ("Int64", "<i8"), "u": ("UInt8", "u1")}
    kind, code = kinds[values.dtype.kind]
    data = values.astype(code).tobytes()
    parts = f' NumberOfComponents="{values.shape[1]}"' if values.ndim == 2 else ""
    content = base64.b64encode(len(data).to_bytes(8, "little") + data).decode()
    return f'<DataArray type="{kind}" Name={quoteattr(name)}{parts} format="binary">{content}</DataArray>\n'


WRITERS = {
    ".off": off,
    ".obj": obj,
    ".ply": ply,
    ".stl": stl,
    ".glb": glb,
    ".vtk": vtk,
    ".vtp": vtp,
    ".xyz": xyz,
}


def own_origin(shape: Shape) -> Float[np.ndarray, "3"]:
    """(3,) what to take off the coordinates so that float32 has digits for the shape: whole numbers, mostly zero."""
    low, high = shape.vertices.min(axis=0), shape.vertices.max(axis=0)
    far = np.abs([low, high]).max() > FAR * np.linalg.norm(high - low)
    return np.round((low + high) / 2) if far else np.zeros(3)


def _face_array(shape: Shape) -> np.ndarray:
    return np.empty((0, 3), dtype=np.int64) if isinstance(shape, PointCloud) else shape.faces


def _rows(array: np.ndarray, form: str) -> str:
    text = io.StringIO()
    np.savetxt(text, array, fmt=form)
    return text.getvalue()
