"""The picture of a comparison: functions on a few shapes, seen from the front and from the back."""

from collections.abc import Sequence

import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from lssd_learn.shapes import Shape
from lssd_learn.view.fields import Field
from lssd_learn.view.painter import paint

WIDEST = 2800  # pixels, of a row of shapes
LARGEST, DPI = 420, 140  # pixels, of the longer side of one shape


def highlight_chart(
    shapes: Sequence[Shape],
    titles: Sequence[str],
    fields: Sequence[Field],
    up: str | None = None,
    azimuth: float = 20.0,
) -> Figure:
    """A row a field with its colour bar; of each shape the front and beside it the back.

    Args:
        shapes: r of them, at one scale.
        titles: one a shape, written below the last row.
        fields: functions on these shapes.
        up: the axis that points up in the shapes; None is y.
        azimuth: degrees from which the fronts are seen, as in `paint`; the backs from the other side.
    """
    size = min(LARGEST, WIDEST // (2 * len(shapes)))
    rows = [_row(shapes, field, size, up or "y", azimuth) for field in fields]
    height, width = rows[0].shape[:2]
    figure = Figure(figsize=(width / DPI + 1.4, len(rows) * (height / DPI + 0.3) + 0.3), layout="constrained", dpi=DPI)
    panels = figure.subplots(len(rows), 1, squeeze=False)[:, 0]
    for panel, row, field in zip(panels, rows, fields, strict=True):
        panel.imshow(row, interpolation="antialiased")
        panel.set(xticks=[], yticks=[])
        panel.spines[:].set_visible(False)
        panel.set_title(field.title, fontsize="medium", loc="left", pad=4)
        colours = ScalarMappable(Normalize(*field.limits), field.colormap)
        signed = field.limits[0] < 0
        bar = figure.colorbar(colours, ax=panel, fraction=0.02, pad=0.01, extend="both" if signed else "max")
        bar.set_label(field.unit, fontsize="small")
    places = (np.arange(len(titles)) + 0.5) * width / len(titles)
    panels[-1].set_xticks(places, titles, fontsize="small")
    panels[-1].tick_params(length=0)
    return figure


def _row(shapes: Sequence[Shape], field: Field, size: int, up: str, azimuth: float) -> np.ndarray:
    """(H, W, 3) uint8: front and back of the first shape, of the second, and so on."""
    # From the height of the shapes, both sides have one outline, and so one scale.
    style = {"size": size, "up": up, "elevation": 0, "colormap": field.colormap, "limits": field.limits}
    sides = [paint(shapes, field.values, azimuth=azimuth + turn, **style) for turn in (0, 180)]
    cells = [np.split(side, len(shapes), axis=1) for side in sides]
    return np.concatenate([cell for front_and_back in zip(*cells, strict=True) for cell in front_and_back], axis=1)
