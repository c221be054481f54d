"""Shapes for TensorBoard's mesh plugin: a few side by side, upright, at one scale."""

from collections.abc import Callable, Sequence
from typing import cast

import numpy as np
import torch
from numpy.typing import ArrayLike
from torch.utils.tensorboard import SummaryWriter

from lssd_learn.shapes import Mesh, Shape

GAP = 0.1  # between two shapes, of their mean width
MOST = 2**16  # vertices: the plugin counts them in 16 bits
POINT = 0.012  # the side of a point, of the longest side of a shape
GREY, BLUE = 190, (70, 110, 170)


def upright(points: ArrayLike, up: str | None) -> np.ndarray:
    """Points (…, 3) turned for viewers that take y for up; None leaves them."""
    points = np.asarray(points)
    return np.stack([points[..., 0], points[..., 2], -points[..., 1]], axis=-1) if up == "z" else points


def add_row(
    writer: SummaryWriter,
    tag: str,
    shapes: Sequence[Shape],
    up: str | None,
    colours: Callable[[int], np.ndarray] | None = None,
) -> None:
    """One scene of the first of `shapes`, as many as the plugin can take; meshes, or clouds where any is a cloud.

    One scene and not one a shape: a browser draws sixteen at a time, each is shown twice, and a sweep has many runs.

    Args:
        up: the axis that points up in them.
        colours: position of a shape → (V, 3) uint8; None is grey for meshes and blue for clouds.
    """
    while len(shapes) > 1 and sum(len(shape.vertices) for shape in shapes) > MOST:
        shapes = shapes[:-1]
    placed = side_by_side([upright(shape.vertices, up) for shape in shapes])
    vertices = np.concatenate(placed)[None]
    solid = all(isinstance(shape, Mesh) for shape in shapes) and vertices.shape[1] <= MOST
    if colours is None:
        painted = np.broadcast_to(np.array(GREY if solid else BLUE, dtype=np.uint8), vertices.shape)
    else:
        painted = np.concatenate([colours(i) for i in range(len(shapes))])[None]
    starts = np.cumsum([0, *(len(points) for points in placed)])
    faces = [cast(Mesh, shape).faces + start for shape, start in zip(shapes, starts, strict=False)] if solid else []
    size = POINT * max(np.ptp(points, axis=0).max() for points in placed)
    writer.add_mesh(
        tag,
        torch.tensor(vertices, dtype=torch.float32),
        colors=torch.tensor(painted),
        faces=torch.tensor(np.concatenate(faces)[None]) if solid else None,
        config_dict=None if solid else {"material": {"cls": "PointsMaterial", "size": size}},
    )


def side_by_side(shapes: Sequence[np.ndarray]) -> list[np.ndarray]:
    """Points (V, 3) of each, moved into a row along x in their order, on one ground; y is up."""
    gap = GAP * np.mean([np.ptp(points[:, 0]) for points in shapes])
    placed, end = [], 0.0
    for points in shapes:
        low, high = points.min(0), points.max(0)
        placed.append(points + [end - low[0], -low[1], -(low[2] + high[2]) / 2])
        end += high[0] - low[0] + gap
    return placed
