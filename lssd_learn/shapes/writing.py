"""Shapes as bytes, for `files.save`. OFF, OBJ, XYZ and PLY keep every digit; STL and GLB hold float32.

Far from the origin float32 has no digits left for the shape. A GLB then lies about its own middle, and its node takes
it to its place; an STL, which has no such thing, is written as text. Other writers round to a fixed number of decimals.
"""

import io
from collections.abc import Mapping
from typing import cast

import numpy as np
import trimesh
from jaxtyping import Float, UInt8

from lssd_learn.shapes.mesh import PointCloud, Shape

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
) -> bytes:
    """Binary PLY, its coordinates float64; with a colour a vertex if given, and numbers by name, as float32."""
    faces = _face_array(shape)
    listed = np.empty(len(faces), dtype=[("count", "u1"), ("corners", "<i4", 3)])
    listed["count"], listed["corners"] = 3, faces
    head = (
        f"ply\nformat binary_little_endian 1.0\nelement vertex {len(shape.vertices)}\n"
        "property double x\nproperty double y\nproperty double z\n"
    )
    rows = shape.vertices.astype("<f8")
    if colours is not None:
        head += "property uchar red\nproperty uchar green\nproperty uchar blue\n"
        rows = np.hstack([rows.view("u1"), colours])
    for name, each in (values or {}).items():
        head += f"property float {name}\n"
        rows = np.hstack([rows.view("u1"), np.asarray(each)[:, None].astype("<f4").view("u1")])
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


WRITERS = {".off": off, ".obj": obj, ".ply": ply, ".stl": stl, ".glb": glb, ".xyz": xyz}


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
