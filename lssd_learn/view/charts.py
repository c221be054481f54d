"""Charts of latent spaces and operators, as matplotlib figures without a display."""

from collections.abc import Mapping, Sequence
from typing import Any, cast

import numpy as np
from matplotlib.colors import TwoSlopeNorm
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, StrMethodFormatter
from numpy.typing import ArrayLike

from lssd_learn.exploration import pca
from lssd_learn.latent import area_difference
from lssd_learn.view.embeddings import scatter, write_names

SHOWN = 400  # shapes of a latent space at a glance


def spectrum_chart(spectrum: ArrayLike, shape_spectra: ArrayLike) -> Figure:
    """The frequencies Λ₀ (m,) of the latent shape, over the range of the shapes' own (n, k)."""
    spectrum = np.asarray(spectrum)
    shape_spectra = np.asarray(shape_spectra)[:, : len(spectrum)]
    figure, axes = _figure(5.2, 3.6)
    index = np.arange(len(spectrum))
    axes.fill_between(index, shape_spectra.min(0), shape_spectra.max(0), color="0.85", label="the shapes")
    axes.plot(index, spectrum, ".-", color="C0", label="latent shape")
    axes.set(xlabel="function", ylabel="eigenvalue", title="Latent spectrum")
    axes.legend(frameon=False)
    return figure


def latent_chart(space) -> Figure:
    """A `LatentSpace` at a glance: its spectrum, and its shapes (of many some) as points, by area operators."""
    figure = Figure(figsize=(7, 2.6), layout="constrained", dpi=90)
    left, right = figure.subplots(1, 2)
    left.plot(np.arange(space.keep), space.spectrum.cpu(), ".-")
    left.set(xlabel="function", ylabel="eigenvalue", title="Latent spectrum")
    some = slice(None, None, -(-len(space) // SHOWN))
    found = pca(area_difference(space.Y[some].cpu()))
    right.scatter(*found.points.numpy().T, c=np.arange(len(found.points)), cmap="viridis", s=12)
    right.set(xlabel=f"{found.ratios[0]:.0%}", ylabel=f"{found.ratios[1]:.0%}", title="Area operators")
    return figure


def pca_chart(
    points: ArrayLike, ratios: ArrayLike, labels: Sequence | None = None, names: Sequence[str] = (), path: bool = False
) -> Figure:
    """Operators as points in the plane of their first two principal components.

    Args:
        points, ratios: of `lssd_learn.exploration.pca`, (n, d) and (d,) of two components or more.
        labels: n, one colour each; None colours by position.
        names: n, written beside the points where there are few.
        path: join the points in order, as of a sequence.
    """
    x, y = np.asarray(points)[:, :2].T
    figure, axes = _figure(5.2, 4.4)
    if path:
        axes.plot(x, y, color="0.75", linewidth=1, zorder=1)
    if labels is None:
        drawn = axes.scatter(x, y, c=np.arange(len(x)), cmap="viridis", zorder=2)
        figure.colorbar(drawn, ax=axes, label="position in the collection")
    else:
        scatter(axes, np.stack([x, y], axis=1), [str(label) for label in labels])
        axes.legend(frameon=False, fontsize="small", loc="center left", bbox_to_anchor=(1, 0.5))
    first, second = np.asarray(ratios)[:2]
    axes.set(xlabel=f"first component ({first:.0%})", ylabel=f"second component ({second:.0%})")
    axes.set_title("Operators of the collection")
    if 0 < len(names) <= 40:
        write_names(axes, names, np.stack([x, y], axis=1))
    return figure


def operator_chart(operators: ArrayLike, titles: Sequence[str], centre: float | None = None) -> Figure:
    """Operators (n, m, m) in rows of two, in one colour scale with a colour bar.

    Args:
        centre: the value drawn white, in a diverging scale; None is a sequential one.
    """
    operators = np.asarray(operators)
    across = min(2, len(operators))
    down = -(-len(operators) // across)
    figure = Figure(figsize=(2.6 * across + 0.8, 2.8 * down), layout="constrained", dpi=110)
    axes = figure.subplots(down, across, squeeze=False).ravel()
    for panel in axes[len(operators) :]:
        panel.set_axis_off()
    if centre is None:
        style = {"cmap": "viridis", "vmin": operators.min(), "vmax": operators.max()}
    else:
        spread = max(np.abs(operators - centre).max(), 1e-12)
        style = {"cmap": "RdBu_r", "norm": TwoSlopeNorm(centre, centre - spread, centre + spread)}
    for panel, operator, title in zip(axes[: len(operators)], operators, titles, strict=True):
        drawn = panel.imshow(operator, interpolation="nearest", **style)
        panel.set_title(title, fontsize="medium")
    figure.colorbar(drawn, ax=list(axes))
    return figure


def collection_chart(image: ArrayLike, operators: ArrayLike, names: Sequence[str]) -> Figure:
    """Painted shapes above their operators.

    Args:
        image: (H, W, 3) uint8, n shapes in a row.
        operators: (n, m, m), shown less their mean over the whole collection.
        names: n.
    """
    operators = np.asarray(operators)
    figure = Figure(figsize=(1.6 * len(operators), 4.6), layout="constrained", dpi=140)
    above, below = cast(Any, figure.subfigures(2, 1, height_ratios=(2, 1)))
    panel = above.subplots()
    panel.imshow(image)
    panel.set_axis_off()
    spread = max(np.quantile(np.abs(operators), 0.97), 1e-12)
    for panel, operator, name in zip(
        below.subplots(1, len(operators), squeeze=False)[0], operators, names, strict=True
    ):
        panel.imshow(operator, cmap="RdBu_r", vmin=-spread, vmax=spread, interpolation="nearest")
        panel.set(xticks=[], yticks=[], title=name)
        panel.title.set_fontsize("small")
    return figure


def growth_chart(curves: Mapping[str, tuple[ArrayLike, ArrayLike, float | None]]) -> Figure:
    """Seconds against the number of shapes, both on logarithmic axes.

    Args:
        curves: name → (numbers, seconds, exponent); with an exponent e the line ~ nᵉ through their middle is drawn.
    """
    figure, axes = _figure(5.2, 4)
    for number, (name, (sizes, seconds, exponent)) in enumerate(curves.items()):
        x, y, color = np.log(sizes), np.log(seconds), f"C{number}"
        label = name if exponent is None else f"{name}: n^{exponent:.2f}"
        axes.loglog(sizes, seconds, "o", color=color, label=label)
        if exponent is not None:
            axes.loglog(sizes, np.exp(y.mean() + exponent * (x - x.mean())), "-", color=color, linewidth=1)
    ticks = sorted({int(n) for sizes, _, _ in curves.values() for n in np.asarray(sizes)})
    axes.set_xticks(ticks, [str(n) for n in ticks])
    axes.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axes.yaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
    axes.minorticks_off()
    axes.set(xlabel="shapes", ylabel="seconds", title="Growth of the stages")
    axes.grid(color="0.9")
    figure.legend(frameon=False, loc="outside lower center")
    return figure


def _figure(width: float, height: float):
    figure = Figure(figsize=(width, height), layout="constrained", dpi=140)
    return figure, figure.subplots()
