"""The picture of `task=agreement`: the same shapes in rows, each in the colours of its own field."""

from collections.abc import Sequence

import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from lssd_learn.shapes import Shape
from lssd_learn.view.fields import Field
from lssd_learn.view.painter import paint

WIDEST, LARGEST, DPI = 2400, 420, 140  # pixels of a row and of a shape; dots an inch


def agreement_chart(
    rows: Sequence[tuple[Sequence[Shape], Field]], titles: Sequence[str], up: str | None = None, azimuth: float = 20.0
) -> Figure:
    """A row a field, each with its colour bar.

    Args:
        rows: shapes and a field on them; as many shapes in each row.
        titles: one a column, written below the last row.
        up: the axis that points up in the shapes; None is y.
        azimuth: degrees from which the shapes are seen, see `paint`.
    """
    size = min(LARGEST, WIDEST // len(titles))
    style = {"size": size, "up": up or "y", "azimuth": azimuth, "elevation": 0}
    images = [paint(s, f.values, colormap=f.colormap, limits=f.limits, **style) for s, f in rows]
    height, width = (max(image.shape[d] for image in images) for d in (0, 1))
    figure = Figure(figsize=(width / DPI + 1.4, len(rows) * (height / DPI + 0.3) + 0.4), layout="constrained", dpi=DPI)
    panels = figure.subplots(len(rows), 1, squeeze=False)[:, 0]
    for panel, image, (_, field) in zip(panels, images, rows, strict=True):
        panel.imshow(image, interpolation="antialiased")
        panel.set(xticks=[], yticks=[])
        panel.spines[:].set_visible(False)
        panel.set_title(field.title, fontsize="medium", loc="left", pad=4)
        colours = ScalarMappable(Normalize(*field.limits), field.colormap)
        bar = figure.colorbar(colours, ax=panel, fraction=0.02, pad=0.01, extend="max")
        bar.set_label(field.unit, fontsize="small")
    places = (np.arange(len(titles)) + 0.5) * images[-1].shape[1] / len(titles)
    panels[-1].set_xticks(places, titles, fontsize="small")
    panels[-1].tick_params(length=0)
    return figure
