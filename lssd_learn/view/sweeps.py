"""Charts of sweeps, as matplotlib figures without a display: a score against what was swept."""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import ArrayLike

LOGARITHMIC = 50  # of positive numbers, the largest over the smallest from which their axis is logarithmic


class Curve(NamedTuple):
    """A score at m points: x (m,) ascending, mean (m,), deviation (m,); NaN is a deviation that is not known."""

    x: ArrayLike
    mean: ArrayLike
    deviation: ArrayLike


def curve_chart(curves: Mapping[str, Curve], xlabel: str, ylabel: str) -> Figure:
    """One line a curve, with a band of one deviation to either side."""
    figure, axes = _figure(6, 4)
    for number, (name, (x, mean, deviation)) in enumerate(curves.items()):
        color, spread = f"C{number % 10}", np.nan_to_num(deviation)
        axes.plot(x, mean, ".-", color=color, label=name)
        axes.fill_between(x, mean - spread, mean + spread, color=color, alpha=0.2, linewidth=0)
    points = np.concatenate([curve.x for curve in curves.values()])
    if points.min() > 0 and points.max() / points.min() >= LOGARITHMIC:
        axes.set_xscale("log")
    axes.set(xlabel=xlabel, ylabel=ylabel)
    axes.grid(color="0.9")
    if len(curves) > 1:
        figure.legend(frameon=False, fontsize="small", loc="outside lower center")
    return figure


def bar_chart(bars: Mapping[str, tuple[float, float]], xlabel: str) -> Figure:
    """One bar a name, in the order given from the top, with a whisker of one deviation to either side.

    Args:
        bars: name → mean and deviation; NaN is a deviation that is not known.
    """
    figure, axes = _figure(6, 1.2 + 0.35 * len(bars))
    means, deviations = np.array(list(bars.values())).T
    position = np.arange(len(bars))
    axes.barh(position, means, xerr=np.nan_to_num(deviations), color="C0", ecolor="0.3", capsize=3, height=0.7)
    axes.set_yticks(position, list(bars))
    axes.invert_yaxis()
    axes.set_xlabel(xlabel)
    axes.grid(axis="x", color="0.9")
    axes.set_axisbelow(True)
    return figure


def _figure(width: float, height: float):
    figure = Figure(figsize=(width, height), layout="constrained", dpi=140)
    return figure, figure.subplots()
