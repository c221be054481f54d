"""Shapes in the colours of a function: as files for other programs, and in TensorBoard."""

from pathlib import Path
from typing import cast

import numpy as np
import trimesh
from PIL import Image
from torch.utils.tensorboard import SummaryWriter

from lssd_learn.errors import InputError
from lssd_learn.shapes import Mesh, Shape
from lssd_learn.view.scenes import upright

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
    path.write_bytes(cast(bytes, made.export(file_type=path.suffix[1:])))


def add_picture(writer: SummaryWriter, tag: str, path: Path) -> None:
    """A PNG file as an image of TensorBoard, no wider than `WIDEST`."""
    with Image.open(path) as picture:
        picture.thumbnail((WIDEST, picture.height))
        writer.add_image(tag, np.asarray(picture.convert("RGB")), dataformats="HWC")
