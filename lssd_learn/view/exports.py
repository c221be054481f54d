"""Shapes as files for other programs."""

import re
from pathlib import Path

from lssd_learn.shapes import Mesh, PointCloud, Shape, save
from lssd_learn.view.scenes import upright


def export(shape: Shape, folder: Path, name: str, up: str | None) -> None:
    """Write NAME.ply, in the shape's own coordinates, and NAME.glb, with y up as viewers of GLB want it.

    Args:
        folder: made if need be.
        name: what a file name may not hold becomes a line.
        up: the axis that points up in the shape; None leaves it.
    """
    folder.mkdir(parents=True, exist_ok=True)
    plain = re.sub(r"[^\w.-]", "_", name)
    points = upright(shape.points, up)
    save(shape, folder / f"{plain}.ply")
    save(Mesh(points, shape.faces) if isinstance(shape, Mesh) else PointCloud(points), folder / f"{plain}.glb")
