"""Shapes in the colours of a function: as files for other programs, and in TensorBoard."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from PIL import Image
from torch.utils.tensorboard import SummaryWriter

from lssd_learn.errors import InputError
from lssd_learn.shapes import Mesh, PointCloud, Shape
from lssd_learn.shapes.writing import glb, ply, vtp
from lssd_learn.view.fields import Field
from lssd_learn.view.scenes import upright

WIDEST = 1600  # pixels of a picture that TensorBoard has to send


def save_coloured(
    shape: Shape,
    colours: np.ndarray,
    path: str | Path,
    up: str | None = None,
    values: Mapping[str, np.ndarray] | None = None,
    space: str = "",
) -> None:
    """Write one shape with a colour a vertex, as PLY, in the shape's own coordinates, or as GLB, with y up.

    Args:
        colours: (V, 3) uint8.
        path: ends in .ply or .glb.
        up: the axis that points up in the shape, which GLB needs to know; None leaves it.
        values: name → (V,), which PLY holds too, as properties of these names.
        space: the coordinate system of the shape, which PLY says too; "" if it is not known.

    Raises:
        InputError: another suffix, a folder that is not there.
    """
    path = Path(path)
    if path.suffix not in (".ply", ".glb") or not path.parent.is_dir():
        raise InputError(f"{path}: expected a .ply or .glb in a folder that exists")
    if path.suffix == ".ply":
        path.write_bytes(ply(shape, colours, values, space))
        return
    points = upright(shape.vertices, up)
    path.write_bytes(glb(Mesh(points, shape.faces) if isinstance(shape, Mesh) else PointCloud(points), colours))


def save_fields(shape: Shape, fields: Sequence[Field], i: int, path: Path, space: str = "") -> None:
    """Write shape i of several fields as VTP, in its own coordinates: the values of each field as an array of its name,
    and its colours as NAME_colours, (V, 3) uint8."""
    values = {field.name: np.asarray(field.values[i], dtype=np.float64) for field in fields}
    path.write_bytes(vtp(shape, values | {f"{field.name}_colours": field.colours(i) for field in fields}, space))


def add_picture(writer: SummaryWriter, tag: str, path: Path) -> None:
    """A PNG file as an image of TensorBoard, no wider than `WIDEST`."""
    with Image.open(path) as picture:
        picture.thumbnail((WIDEST, picture.height))
        writer.add_image(tag, np.asarray(picture.convert("RGB")), dataformats="HWC")
