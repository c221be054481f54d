"""Charts of the regression study, in the manner of the paper's figures, without a display."""

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import ArrayLike

from lssd_learn.view.sweeps import Curve

MARKERS = "osD^v"
SMOOTHING = 10  # epochs a curve of a training is averaged over: an epoch of six steps jumps


def functions_chart(
    lines: Mapping[str, Curve], points: Mapping[str, Curve], levels: Mapping[str, float], ylabel: str
) -> Figure:
    """A score against the number of functions: some curves as solid lines, some as scattered points, some levels.

    Args:
        lines, points: name → x, mean and deviation; equal names take equal colours, in the order of first mention.
        levels: name → a score that knows no number of functions, drawn dashed.
        ylabel: the score.
    """
    figure = Figure(figsize=(6.4, 4.4), layout="constrained", dpi=140)
    axes = figure.subplots()
    families = list(dict.fromkeys(_family(name) for name in [*lines, *points]))
    for name, (x, mean, deviation) in lines.items():
        color, spread = f"C{families.index(_family(name))}", np.nan_to_num(deviation)
        axes.plot(x, mean, "-", color=color, label=name)
        axes.fill_between(x, mean - spread, mean + spread, color=color, alpha=0.12, linewidth=0)
    for name, (x, mean, deviation) in points.items():
        family = families.index(_family(name))
        style = {"fmt": MARKERS[family % len(MARKERS)], "color": f"C{family}", "capsize": 2, "markersize": 5}
        axes.errorbar(x, mean, yerr=np.nan_to_num(deviation), label=name, **style)
    for number, (name, value) in enumerate(levels.items()):
        axes.axhline(value, color="0.2" if number == 0 else "0.6", linestyle="--", linewidth=1.2, label=name)
    axes.set(xlabel="number of functions", ylabel=ylabel, ylim=(0, None))
    axes.grid(color="0.92")
    figure.legend(frameon=False, fontsize="small", loc="outside right upper")
    return figure


def trends_chart(panels: Sequence[Mapping[str, Mapping[str, ArrayLike]]], ylabel: str) -> Figure:
    """How errors fall in training: a panel each, a colour a net, solid on training shapes and dashed on others.

    Args:
        panels: of each, net → {"train": (epochs,), "validation": (epochs,)} errors after each epoch.
        ylabel: the error.
    """
    figure = Figure(figsize=(4.2 * len(panels), 3.6), layout="constrained", dpi=140)
    for axes, nets in zip(np.atleast_1d(figure.subplots(1, len(panels), sharey=True)), panels, strict=True):
        for number, (name, curves) in enumerate(nets.items()):
            for part, style in (("train", "-"), ("validation", "--")):
                values = _smooth(np.asarray(curves[part], float))
                epochs = np.arange(len(values)) + SMOOTHING
                axes.plot(epochs, values, style, color=f"C{number}", linewidth=1.2, label=f"{name}, {part}")
        axes.set(xlabel="epoch", yscale="log")
        axes.grid(color="0.92", which="both")
        axes.legend(frameon=False, fontsize="small", ncols=2, loc="lower center", bbox_to_anchor=(0.5, 1))
    figure.axes[0].set_ylabel(ylabel)
    return figure


def _family(name: str) -> str:
    """What comes after the net: "CNN, clique" and "MLP, clique" look at the same network."""
    return name.partition(", ")[2]


def _smooth(values: np.ndarray) -> np.ndarray:
    return np.convolve(values, np.full(SMOOTHING, 1 / SMOOTHING), mode="valid")
