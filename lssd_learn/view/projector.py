"""The collection in TensorBoard's projector: a point a shape, to be turned, searched and coloured by what is known."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike
from tensorboard.plugins import projector

NAME = "operators"


def write_projector(folder: Path, points: ArrayLike, columns: Mapping[str, Sequence]) -> None:
    """Write projector_config.pbtxt, operators.tsv and labels.tsv, over earlier ones.

    TensorBoard looks for them in a folder that holds event files, and labels the points by the first column. Of a
    column of numbers it makes a colour scale, but of 50 different values or fewer, as of texts, separate colours.

    Args:
        folder: of the event files.
        points: (n, d) of n shapes.
        columns: title → n texts or numbers.
    """
    np.savetxt(folder / f"{NAME}.tsv", np.asarray(points), fmt="%.5g", delimiter="\t")
    rows = [[_cell(value) for value in row] for row in zip(*columns.values(), strict=True)]
    if len(columns) > 1:  # a single column has no title
        rows.insert(0, [_cell(title) for title in columns])
    (folder / "labels.tsv").write_text("".join("\t".join(row) + "\n" for row in rows), encoding="utf-8")
    config = projector.ProjectorConfig()
    config.embeddings.add(tensor_name=NAME, tensor_path=f"{NAME}.tsv", metadata_path="labels.tsv")
    projector.visualize_embeddings(str(folder), config)


def _cell(value) -> str:
    if isinstance(value, float | np.floating):
        return f"{value:.4g}"
    return " ".join(str(value).split())  # a tab or a line break would be another column or row
