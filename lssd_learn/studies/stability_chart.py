"""The picture of `task=stability`: the shapes, changes of basis as matrices, and spectra."""

from collections.abc import Mapping, Sequence
from typing import Any, cast

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import ArrayLike

DPI = 140


def stability_chart(
    image: np.ndarray, titles: Sequence[str], matrices: Mapping[str, ArrayLike], spectra: Mapping[str, ArrayLike]
) -> Figure:
    """Shapes in a row, and below them the absolute values of matrices in one grey scale, and curves of eigenvalues.

    Args:
        image: (H, W, 3) uint8, the painted shapes.
        titles: one a shape.
        matrices: title → (m, p).
        spectra: name → eigenvalues; the first is drawn as a line, those after it as dots.
    """
    across = len(matrices) + 1
    figure = Figure(figsize=(3.1 * across, 6.0), layout="constrained", dpi=DPI)
    above, below = cast(Any, figure.subfigures(2, 1, height_ratios=(0.8, 1)))
    panel = above.subplots()
    panel.imshow(image)
    panel.set(yticks=[])
    panel.set_xticks((np.arange(len(titles)) + 0.5) * image.shape[1] / len(titles), titles, fontsize="small")
    panel.tick_params(length=0)
    panel.spines[:].set_visible(False)
    panels = below.subplots(1, across)
    for panel, (title, matrix) in zip(panels, matrices.items(), strict=False):
        drawn = panel.imshow(np.abs(np.asarray(matrix)), cmap="Greys", vmin=0, vmax=1, interpolation="nearest")
        panel.set_title(title, fontsize="small")
    bar = below.colorbar(drawn, ax=panels[: len(matrices)].tolist(), fraction=0.02, pad=0.01, extend="max")
    bar.set_label("entry, without its sign", fontsize="small")
    for number, (name, values) in enumerate(spectra.items()):
        style = {"linewidth": 3, "color": "0.75"} if number == 0 else {"marker": ".", "markersize": 4, "linewidth": 0}
        panels[-1].plot(np.asarray(values), label=name, **style)
    panels[-1].set_title("spectrum", fontsize="small")
    panels[-1].set(xlabel="function", ylabel="eigenvalue")
    panels[-1].legend(frameon=False, fontsize="x-small")
    return figure
