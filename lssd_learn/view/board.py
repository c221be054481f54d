"""What TensorBoard shows of a collection and its latent space, before anything is learnt."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import torch
from numpy.typing import ArrayLike
from torch.utils.tensorboard import SummaryWriter

from lssd_learn.shapes import Mesh, Shape
from lssd_learn.view.charts import operator_chart, pca_chart, spectrum_chart

SHOWN = 4  # operators and shapes a page


def upright(points: ArrayLike, up: str | None) -> np.ndarray:
    """Points (…, 3) turned for viewers that take y for up; None leaves them."""
    points = np.asarray(points)
    return np.stack([points[..., 0], points[..., 2], -points[..., 1]], axis=-1) if up == "z" else points


def write_board(
    folder: Path,
    *,
    operators: ArrayLike,
    names: Sequence[str],
    spectrum: ArrayLike,
    shape_spectra: ArrayLike,
    points: ArrayLike,
    ratios: ArrayLike,
    labels: Sequence | None,
    shapes: Sequence[Shape],
    up: str | None,
) -> None:
    """Write one page: latent spectrum, operators and their mean, the map of the collection, some shapes.

    Args:
        folder: of the event files.
        operators: (n, m, m) of one kind.
        names: n.
        spectrum, shape_spectra: (m,) and (n, k).
        points, ratios, labels: see `pca_chart`.
        shapes: the first few of the collection.
        up: the axis that points up in them.
    """
    operators = np.asarray(operators)
    first = list(names[:SHOWN])
    mean = operators.mean(0)
    with SummaryWriter(folder) as writer:
        writer.add_figure("latent/spectrum", spectrum_chart(spectrum, shape_spectra))
        writer.add_figure("latent/collection", pca_chart(points, ratios, labels))
        writer.add_figure("operators/mean", operator_chart(mean[None], ["mean"]))
        writer.add_figure("operators/minus mean", operator_chart(operators[:SHOWN] - mean, first, centre=0.0))
        for value_index, value in enumerate(np.asarray(spectrum)):
            writer.add_scalar("latent/frequency", value, value_index)
        for shape, name in zip(shapes[:SHOWN], first, strict=False):
            _add_shape(writer, f"shapes/{name}", shape, up)


def _add_shape(writer: SummaryWriter, tag: str, shape: Shape, up: str | None) -> None:
    vertices = torch.tensor(upright(shape.vertices, up)[None], dtype=torch.float32)
    faces = torch.tensor(shape.faces[None]) if isinstance(shape, Mesh) else None
    grey = torch.full(vertices.shape, 190, dtype=torch.uint8)
    writer.add_mesh(tag, vertices, colors=grey, faces=faces)
