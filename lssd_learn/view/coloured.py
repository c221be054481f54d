"""Shapes in the colours of a function: as files for other programs, and in TensorBoard."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import torch
import trimesh
from PIL import Image
from torch.utils.tensorboard import SummaryWriter

from lssd_learn.errors import InputError
from lssd_learn.shapes import Mesh, Shape
from lssd_learn.view.fields import Field
from lssd_learn.view.scenes import MOST, POINT, side_by_side, upright

WIDEST = 1600  # pixels of a picture that TensorBoard has to send


def save_coloured(shape: Shape, colours: np.ndarray, path: str | Path, up: str | None = None) -> None:
    """Write one shape with a colour a vertex, as PLY, in the shape's own coordinates, or as GLB, with y up.

    Args:
        colours: (V, 3) uint8.
        path: ends in .ply or .glb.
        up: the axis that points up in the shape, which GLB needs to know; None leaves it.

    Raises:
        InputError: another suffix, a folder that is not there.
    """
    path = Path(path)
    if path.suffix not in (".ply", ".glb") or not path.parent.is_dir():
        raise InputError(f"{path}: expected a .ply or .glb in a folder that exists")
    vertices = upright(shape.vertices, up) if path.suffix == ".glb" else shape.vertices
    if isinstance(shape, Mesh):
        made = trimesh.Trimesh(vertices, shape.faces, vertex_colors=colours, process=False)
    else:
        made = trimesh.PointCloud(vertices, colors=colours)
    made = trimesh.Scene(made) if path.suffix == ".glb" else made
    path.write_bytes(made.export(file_type=path.suffix[1:]))


def add_picture(writer: SummaryWriter, tag: str, path: Path) -> None:
    """A PNG file as an image of TensorBoard, no wider than `WIDEST`."""
    with Image.open(path) as picture:
        picture.thumbnail((WIDEST, picture.height))
        writer.add_image(tag, np.asarray(picture.convert("RGB")), dataformats="HWC")


def add_coloured_row(writer: SummaryWriter, tag: str, shapes: Sequence[Shape], field: Field, up: str | None) -> None:
    """One scene of TensorBoard's mesh plugin: the first shapes of `field` side by side, as many as it can take."""
    while len(shapes) > 1 and sum(len(shape.vertices) for shape in shapes) > MOST:
        shapes = shapes[:-1]
    placed = side_by_side([upright(shape.vertices, up) for shape in shapes])
    vertices = np.concatenate(placed)[None]
    solid = all(isinstance(shape, Mesh) for shape in shapes) and vertices.shape[1] <= MOST
    starts = np.cumsum([0, *(len(points) for points in placed)])
    faces = [shape.faces + start for shape, start in zip(shapes, starts, strict=False)] if solid else []
    size = POINT * max(np.ptp(points, axis=0).max() for points in placed)
    writer.add_mesh(
        tag,
        torch.tensor(vertices, dtype=torch.float32),
        colors=torch.tensor(np.concatenate([field.colours(i) for i in range(len(shapes))])[None]),
        faces=torch.tensor(np.concatenate(faces)[None]) if solid else None,
        config_dict=None if solid else {"material": {"cls": "PointsMaterial", "size": size}},
    )
