"""Charts of embeddings side by side: the same shapes, seen in several ways."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import cast

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import ArrayLike

UNLABELLED = "0.75"  # the grey of shapes without a label
FEW = 24  # shapes up to which their names stand beside them
LETTER, SMALL_LETTER = 0.085, 0.055  # inches that a letter takes, in a legend and beside a point
MANY = 1000  # shapes from which on their dots shrink


@dataclass(frozen=True)
class Panel:
    """One embedding: `points` (n, 2), `ratios` (2,), the part of the variance along each axis, and a `title`."""

    points: ArrayLike
    ratios: ArrayLike
    title: str


def embedding_chart(
    rows: Sequence[Sequence[Panel]], labels: Sequence[str | None], names: Sequence[str] = (), path: bool = False
) -> Figure:
    """A colour a label, in the order of their first appearance; grey for None.

    Args:
        rows: of panels, as many in each, of n shapes each.
        labels: n.
        names: n, written beside the points where there are few.
        path: join the points in their order, as of a sequence.
    """
    across = len(rows[0])
    figure = Figure(figsize=(4.6 * across, 3.9 * len(rows) + 0.5), layout="constrained", dpi=140)
    grid = figure.subplots(len(rows), across, squeeze=False)
    for axes, panel in zip(grid.ravel(), (panel for row in rows for panel in row), strict=True):
        points = np.asarray(panel.points, dtype=float)
        if path:
            axes.plot(*points.T, color="0.8", linewidth=1, zorder=0)
        scatter(axes, points, labels)
        first, second = np.asarray(panel.ratios)[:2]
        axes.set(xlabel=f"first component ({first:.0%})", ylabel=f"second component ({second:.0%})")
        axes.set_title(panel.title, fontsize="medium")
        axes.grid(color="0.93")
        axes.set_axisbelow(True)
    if len(set(labels)) > 1:
        handles = grid[0, 0].get_legend_handles_labels()
        longest = max(map(len, handles[1]))
        columns = max(1, min(6, int(4.6 * across / (LETTER * longest + 0.5))))
        figure.legend(*handles, frameon=False, fontsize="small", loc="outside lower center", ncols=columns)
    if 0 < len(names) <= FEW:
        for axes, panel in zip(grid.ravel(), (panel for row in rows for panel in row), strict=True):
            write_names(axes, names, np.asarray(panel.points, dtype=float))
    return figure


def write_names(axes: Axes, names: Sequence[str], points: np.ndarray) -> None:
    """Names beside their points (n, 2), where they lie on no point, no other name and within the axes; of those that
    find no such place each is left out. Axes are left as large as they are: to be called when all else is drawn.
    """
    figure = cast(Figure, axes.get_figure())
    figure.draw_without_rendering()  # now the layout stands
    inch = figure.dpi
    frame = axes.get_window_extent()
    x, y = axes.transData.transform(points).T
    high, gap = 0.09 * inch, 0.05 * inch
    dots = np.stack([x - 0.6 * gap, y - 0.6 * gap, x + 0.6 * gap, y + 0.6 * gap], axis=1)
    taken = list(dots)
    for i, name in enumerate(names):
        wide = SMALL_LETTER * inch * len(name)
        corners = [(gap, gap), (gap, -gap - high), (-gap - wide, gap), (-gap - wide, -gap - high)]
        sides = [(gap, -high / 2), (-gap - wide, -high / 2), (-wide / 2, gap), (-wide / 2, -gap - high)]
        for dx, dy in corners + sides:
            box = np.array([x[i] + dx, y[i] + dy, x[i] + dx + wide, y[i] + dy + high])
            inside = box[0] > frame.x0 and box[1] > frame.y0 and box[2] < frame.x1 and box[3] < frame.y1
            others = np.array(taken)
            apart = (box[:2] > others[:, 2:]).any(1) | (box[2:] < others[:, :2]).any(1)
            if inside and apart.all():
                taken.append(box)
                offset = (dx * 72 / inch, dy * 72 / inch)
                axes.annotate(name, points[i], textcoords="offset points", xytext=offset, fontsize=6, va="bottom")
                break


def label_colours(labels: Sequence[str | None]) -> dict[str | None, str]:
    """Label → colour of matplotlib, grey for None, which comes first so that it is drawn below."""
    known = [label for label in dict.fromkeys(labels) if label is not None]
    grey = {None: UNLABELLED} if any(label is None for label in labels) else {}
    return grey | {label: f"C{number % 10}" for number, label in enumerate(known)}


def scatter(axes: Axes, points: np.ndarray, labels: Sequence[str | None]) -> None:
    """Points (n, 2) in the colours of their labels, and these for a legend.

    Where there are many, dots are small, and drawn in a mixed order: no group lies on top of another. Those without a
    label lie below all.
    """
    colours = label_colours(labels)
    for label, colour in colours.items():
        axes.scatter([], [], color=colour, label="no label" if label is None else label)
    order = np.random.default_rng(0).permutation(len(points))
    order = order[np.argsort([labels[i] is not None for i in order], kind="stable")]
    size = 20 * min(1, MANY / len(points))
    axes.scatter(*points[order].T, s=max(size, 2), c=[colours[labels[i]] for i in order], zorder=2)
