"""Charts of embeddings side by side: the same shapes, seen in several ways."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import ArrayLike

UNLABELLED = "0.75"  # the grey of shapes without a label
FEW = 24  # shapes up to which their names stand beside them
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
        for name, place in zip(names if len(names) <= FEW else (), points, strict=False):
            axes.annotate(name, place, textcoords="offset points", xytext=(4, 3), fontsize=6)
        first, second = np.asarray(panel.ratios)[:2]
        axes.set(xlabel=f"first component ({first:.0%})", ylabel=f"second component ({second:.0%})")
        axes.set_title(panel.title, fontsize="medium")
        axes.grid(color="0.93")
        axes.set_axisbelow(True)
    if len(set(labels)) > 1:
        handles = grid[0, 0].get_legend_handles_labels()
        figure.legend(*handles, frameon=False, fontsize="small", loc="outside lower center", ncols=6)
    return figure


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
