"""The pictures every run leaves of its collection and latent space: as PNG and in TensorBoard."""

from collections.abc import Sequence
from pathlib import Path
from typing import cast

import numpy as np
from numpy.typing import ArrayLike

from lssd_learn.collections.base import Collection
from lssd_learn.collections.previews import previews
from lssd_learn.exploration import pca
from lssd_learn.pieces import Pieces
from lssd_learn.shapes import PointCloud
from lssd_learn.view.board import SHOWN, write_board
from lssd_learn.view.charts import collection_chart, pca_chart, spectrum_chart
from lssd_learn.view.painter import paint

PAINTED = 8
MOST = 10_000  # shapes on the page, evenly spread over more of them: TensorBoard itself shows no more
PROJECTED = 50  # principal components in the projector, most of the variance in a file of a few hundred kilobytes


def write_overview(pieces: Pieces, out: Path, pictures: bool = False, clouds: ArrayLike | None = None) -> None:
    """Fill the TensorBoard page of a run.

    Of more than `MOST` shapes some are shown.

    Args:
        pictures: collection.png, spectrum.png and pca.png too, and the spectrum as a curve.
        clouds: (n, V, 3) what a net reads instead of the operators, to be seen in place of the shapes.
    """
    pipeline, latent = pieces.pipeline, pieces.pipeline.latent
    collection = pipeline.collection
    operators = pipeline.operators(pieces.operators)
    columns, evals = _columns(collection), latent.evals
    if (step := -(-len(operators) // MOST)) > 1:
        collection, operators, evals = collection[::step], operators[::step], evals[::step]
        columns = {title: values[::step] for title, values in columns.items()}
        clouds = None if clouds is None else np.asarray(clouds)[::step]
    embedding = pca(operators, min(PROJECTED, max(2, len(operators) - 1)))
    labels = cast(Sequence | None, next(iter(collection.groups.values()), None))
    if clouds is None:
        shapes = previews(collection, SHOWN, pipeline.cache)
    else:
        shapes = [PointCloud(cloud) for cloud in np.asarray(clouds)[:SHOWN]]
    write_board(
        out / "tensorboard",
        operators=operators[:, 0],
        names=collection.names,
        columns=columns,
        spectrum=latent.spectrum,
        shape_spectra=evals,
        points=embedding.points,
        ratios=embedding.ratios,
        labels=labels,
        shapes=shapes,
        up=collection.up,
        curves=pictures,
    )
    if pictures:
        few = previews(collection, PAINTED, pipeline.cache)
        painted = paint(few, up=collection.up or "y", size=420)
        centred = (operators - operators.mean(0))[: len(few), 0]
        collection_chart(painted, centred, collection.names[: len(few)]).savefig(out / "collection.png")
        spectrum_chart(latent.spectrum, evals).savefig(out / "spectrum.png")
        chart = pca_chart(embedding.points, embedding.ratios, labels, collection.names, path=pipeline.in_order)
        chart.savefig(out / "pca.png")


def _columns(collection: Collection) -> dict[str, Sequence]:
    """Groups and parameters, title → n values."""
    parameters = () if collection.parameters is None else collection.parameters.T
    return cast(
        dict[str, Sequence], {**collection.groups, **dict(zip(collection.parameter_names, parameters, strict=True))}
    )
