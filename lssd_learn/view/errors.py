"""How many stay below an error: the usual picture of how good maps are."""

from collections.abc import Mapping

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import ArrayLike


def cumulative_chart(errors: Mapping[str, ArrayLike], label: str, end: float | None = None) -> Figure:
    """For each of several series (n,) the share of it, in percent, that lies below an error.

    Args:
        errors: name → numbers, 0 or more.
        label: what they are.
        end: of the axis; None is the largest error.
    """
    figure = Figure(figsize=(5.2, 3.6), layout="constrained")
    axes = figure.subplots()
    most = max(float(np.max(some)) for some in errors.values())
    for name, some in errors.items():
        some = np.sort(np.asarray(some, dtype=float))
        share = 100 * np.arange(1, len(some) + 1) / len(some)
        axes.step([0, *some, most], [0, *share, 100], where="post", label=f"{name}, median {np.median(some):.3g}")
    axes.set(xlabel=label, ylabel="% below", xlim=(0, end or most or 1), ylim=(0, 101))
    axes.legend(frameon=False, loc="lower right")
    return figure
