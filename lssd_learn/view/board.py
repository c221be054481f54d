"""What TensorBoard shows of a collection and its latent space, before anything is learnt."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import ArrayLike
from torch.utils.tensorboard import SummaryWriter

from lssd_learn.shapes import Shape
from lssd_learn.view.charts import operator_chart, pca_chart, spectrum_chart
from lssd_learn.view.projector import write_projector
from lssd_learn.view.scenes import add_row

SHOWN = 4  # operators and shapes a page
SUFFIX, COMMAND = ".board", ".command"  # of the event files
# A card of TensorBoard is some 300 pixels wide and drops the pixels between: letters have to be large, lines broad.
WIDEST, DPI = 4.0, 150  # inches


def write_board(
    folder: Path,
    *,
    operators: ArrayLike,
    names: Sequence[str],
    columns: Mapping[str, Sequence],
    spectrum: ArrayLike,
    shape_spectra: ArrayLike,
    points: ArrayLike,
    ratios: ArrayLike,
    labels: Sequence | None,
    shapes: Sequence[Shape],
    up: str | None,
    curves: bool = False,
) -> None:
    """Write one page: latent spectrum, operators and their mean, maps of the collection, some shapes.

    A page that stands in the folder already, as that of a run resumed in place, is replaced.

    Args:
        folder: of the event files.
        operators: (n, m, m) of one kind.
        names: n.
        columns: title → n texts or numbers, what else is known of the shapes.
        spectrum, shape_spectra: (m,) and (n, k).
        points, ratios: (n, d) and (d,), principal components; a chart of the first two, all of them in the projector.
        labels: see `pca_chart`.
        shapes: the first few of the collection, or what a net reads of them.
        up: the axis that points up in them.
        curves: the spectrum as scalars too, where no training run would list them among its scores.
    """
    operators = np.asarray(operators)
    first = list(names[:SHOWN])
    mean = operators.mean(0)
    folder.mkdir(parents=True, exist_ok=True)
    for old in folder.glob(f"*{SUFFIX}"):
        old.unlink()
    with SummaryWriter(folder, filename_suffix=SUFFIX) as writer:
        writer.add_figure("latent/spectrum", _card(spectrum_chart(spectrum, shape_spectra)))
        writer.add_figure("latent/collection", _card(pca_chart(points, ratios, labels)))
        writer.add_figure("operators/mean", _card(operator_chart(mean[None], ["mean"])))
        writer.add_figure("operators/minus_mean", _card(operator_chart(operators[:SHOWN] - mean, first, centre=0.0)))
        if curves:
            _add_spectrum(writer, np.asarray(spectrum), np.asarray(shape_spectra))
        add_row(writer, "shapes/first", shapes[:SHOWN], up)
        writer.add_text("shapes/first", f"From left to right: {', '.join(first)}.")  # MESH shows no names
    write_projector(folder, points, {"name": names, **columns})


def write_command(folder: Path, command: str) -> None:
    """Say under TEXT what command has made the page; one of an earlier run in the folder is replaced."""
    for old in folder.glob(f"*{COMMAND}"):
        old.unlink()
    with SummaryWriter(folder, filename_suffix=COMMAND) as writer:
        writer.add_text("command", f"    {command}")


def _card(figure: Figure) -> Figure:
    width, height = figure.get_size_inches()
    figure.set_size_inches(min(1, WIDEST / width) * width, min(1, WIDEST / width) * height)
    figure.set_dpi(DPI)
    return figure


def _add_spectrum(writer: SummaryWriter, spectrum: np.ndarray, shape_spectra: np.ndarray) -> None:
    """Eigenvalues over the number of the function, and one chart of the latent shape's in the range of the shapes'."""
    tags = [f"spectrum/{name}" for name in ("latent", "lowest", "highest")]
    for number, values in enumerate(zip(spectrum, shape_spectra.min(0), shape_spectra.max(0), strict=False)):
        for tag, value in zip(tags, values, strict=True):
            writer.add_scalar(tag, value, number)
    writer.add_custom_scalars({"latent space": {"eigenvalues: latent, range of the shapes": ["Margin", tags]}})
