"""Pairs of shapes in matching colours: points that a map joins are of one colour, and a person sees where it fails."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Int
from matplotlib.figure import Figure

from lssd_learn.shapes import Mesh
from lssd_learn.shapes.kabsch import kabsch
from lssd_learn.view.painter import paint

COLOURS = "turbo"
DPI = 130


@dataclass(frozen=True, eq=False)
class Pair:
    """Two meshes and a map.

    Attributes:
        title: written over them.
        source, target: the meshes.
        there: (V_target,) for each vertex of the target the vertex of the source.
    """

    title: str
    source: Mesh
    target: Mesh
    there: Int[np.ndarray, " V_target"]


def match_sheet(pairs: Sequence[Pair], size: int = 260) -> Figure:
    """A row a pair: source and target in colours that follow the source's length, and again those of its breadth.

    Both stand along the source's longest axis; the target is turned onto the source by the map itself.

    Args:
        pairs: at least one.
        size: the longer side of a shape, in pixels.
    """
    rows = [_row(pair, size) for pair in pairs]
    width = max(row.shape[1] for row in rows)
    figure = Figure(figsize=(width / DPI, sum(row.shape[0] + 40 for row in rows) / DPI), dpi=DPI, layout="constrained")
    heights = [row.shape[0] + 40 for row in rows]
    for axes, row, pair in zip(
        np.atleast_1d(figure.subplots(len(rows), height_ratios=heights)), rows, pairs, strict=True
    ):
        axes.imshow(row)
        axes.set_title(pair.title, fontsize="small")
        axes.set_axis_off()
    return figure


def _row(pair: Pair, size: int) -> np.ndarray:
    source = pair.source.vertices - pair.source.vertices.mean(axis=0)
    axes = np.linalg.eigh(source.T @ source)[1][:, [1, 0, 2]]  # the longest upwards, the shortest away from the viewer
    axes[:, 1] *= np.linalg.det(axes)
    source = source @ axes
    goals = source[pair.there]
    middle = pair.target.vertices.mean(axis=0)
    target = (pair.target.vertices - middle) @ kabsch(pair.target.vertices - middle, goals - goals.mean(axis=0))
    target *= np.sqrt(pair.source.area / pair.target.area)
    shapes = [Mesh(source, pair.source.faces), Mesh(target, pair.target.faces)]
    seen = []
    for axis in (2, 0):
        values = source[:, axis]
        seen.append(paint(shapes, [values, values[pair.there]], size=size, azimuth=0, elevation=0, colormap=COLOURS))
    return np.concatenate(seen, axis=1)
