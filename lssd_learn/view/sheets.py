"""Sheets of shapes in rows and columns, all at one scale: the truth above its reconstruction, a path, an analogy."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from torch.utils.tensorboard import SummaryWriter

from lssd_learn.shapes import Shape
from lssd_learn.view.painter import paint
from lssd_learn.view.scenes import add_row

SUFFIX = ".sheets"  # of the event file
DPI = 130
LETTER = 0.08  # inches that a letter of a title takes
FONT = 8.3  # points; titles wider than their shape are smaller
GAP = 36  # pixels over a row, for titles of two lines


def shape_sheet(
    rows: Mapping[str, Mapping[str, Shape | None]], up: str | None, azimuth: float = 20.0, size: int = 300
) -> Figure:
    """A picture of shapes.

    Args:
        rows: title → shapes by their own titles, which are written over each that differs from the one above; None
            leaves a place empty.
        up: the axis that points up in them; None is y.
        azimuth: degrees from which they are seen, see `paint`.
        size: the longer side of a shape, in pixels.

    Raises:
        InputError: nothing to show.
    """
    shapes = [shape for row in rows.values() for shape in row.values() if shape is not None]
    strip = paint(shapes, up=up or "y", azimuth=azimuth, size=size)
    height, width = strip.shape[0], strip.shape[1] // len(shapes)
    across = max(len(row) for row in rows.values())
    image = np.full((len(rows) * (height + GAP), across * width, 3), 255, dtype=np.uint8)
    wide, high, margin = image.shape[1] / DPI, image.shape[0] / DPI, LETTER * max(map(len, rows)) + 0.2
    figure = Figure(figsize=(margin + wide, high), dpi=DPI)
    axes = figure.add_axes((margin / (margin + wide), 0, wide / (margin + wide), 1))
    longest = max(len(line) for row in rows.values() for title in row for line in title.split("\n"))
    font = FONT * min(1, width / (LETTER * DPI * max(longest, 1)))
    cells, above = iter(np.split(strip, len(shapes), axis=1)), []
    for i, row in enumerate(rows.values()):
        top = i * (height + GAP)
        for j, (title, shape) in enumerate(row.items()):
            if shape is not None:
                image[top + GAP : top + GAP + height, j * width : (j + 1) * width] = next(cells)
            if above[j : j + 1] != [title]:
                axes.text((j + 0.5) * width, top + GAP, title, ha="center", va="bottom", fontsize=font)
        above = list(row)
    axes.imshow(image)
    axes.set_xticks([])
    axes.set_yticks([(i + 0.5) * (height + GAP) + GAP / 2 for i in range(len(rows))], list(rows), fontsize=FONT)
    axes.tick_params(length=0)
    axes.spines[:].set_visible(False)
    return figure


def write_sheets(
    folder: Path, figures: Mapping[str, Figure], scenes: Mapping[str, Sequence[Shape]], up: str | None
) -> None:
    """One TensorBoard page; one that stands in the folder already, as that of a run resumed in place, is replaced.

    Args:
        folder: of the event files.
        figures: tag → picture.
        scenes: tag → shapes side by side, see `add_row`.
        up: the axis that points up in them.
    """
    folder.mkdir(parents=True, exist_ok=True)
    for old in folder.glob(f"*{SUFFIX}"):
        old.unlink()
    with SummaryWriter(folder, filename_suffix=SUFFIX) as writer:
        for tag, figure in figures.items():
            writer.add_figure(tag, figure)
        for tag, shapes in scenes.items():
            add_row(writer, tag, shapes, up)
