"""How far carried landmarks are off: each landmark, by the number of hubs, and beside their error bars."""

from collections.abc import Mapping, Sequence

import numpy as np
from jaxtyping import Float
from matplotlib.figure import Figure


def benchmark_chart(
    labels: Sequence[str],
    errors: Float[np.ndarray, "m L"],
    bars: Float[np.ndarray, "m L"],
    by_count: Mapping[int, float],
) -> Figure:
    """Three panels.

    Args:
        labels: of L landmarks.
        errors, bars: of m shapes, in their units; NaN where there is none.
        by_count: number of hubs → mean error.
    """
    figure = Figure(figsize=(12, 3.8), layout="constrained")
    first, second, third = figure.subplots(1, 3, width_ratios=(max(1.0, len(labels) / 12), 1, 1))
    first.boxplot([column[np.isfinite(column)] for column in errors.T], tick_labels=list(labels), widths=0.6)
    first.tick_params(axis="x", rotation=90, labelsize="small")
    first.set(ylabel="error", title="Each landmark", ylim=(0, None))
    second.scatter(bars, errors, s=8, alpha=0.5, edgecolors="none")
    most = float(np.nanmax(errors))
    second.plot([0, most], [0, most], color="0.7", linewidth=1, zorder=0)
    second.set(xlabel="error bar", ylabel="error", title="Errors against their bars", xlim=(0, None), ylim=(0, None))
    third.plot(list(by_count), list(by_count.values()), "o-")
    third.set(xlabel="hubs", ylabel="mean error", title="One hub against several", ylim=(0, None))
    third.set_xticks(list(by_count))
    return figure
