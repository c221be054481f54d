"""Shapes in the colours of a function: as files for other programs, and in TensorBoard."""

from pathlib import Path

import numpy as np
from PIL import Image
from torch.utils.tensorboard import SummaryWriter

from lssd_learn.errors import InputError
from lssd_learn.shapes import Mesh, PointCloud, Shape
from lssd_learn.shapes.writing import glb, ply
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
    if path.suffix == ".ply":
        path.write_bytes(ply(shape, colours))
        return
    points = upright(shape.vertices, up)
    path.write_bytes(glb(Mesh(points, shape.faces) if isinstance(shape, Mesh) else PointCloud(points), colours))


def add_picture(writer: SummaryWriter, tag: str, path: Path) -> None:
    """A PNG file as an image of TensorBoard, no wider than `WIDEST`."""
    with Image.open(path) as picture:
        picture.thumbnail((WIDEST, picture.height))
        writer.add_image(tag, np.asarray(picture.convert("RGB")), dataformats="HWC")
