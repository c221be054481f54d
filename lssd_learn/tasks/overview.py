"""The pictures every run leaves of its collection and latent space: as PNG and in TensorBoard."""

from pathlib import Path

from lssd_learn.collections.previews import previews
from lssd_learn.exploration import pca
from lssd_learn.latent import MapNetwork
from lssd_learn.pipeline import Pipeline
from lssd_learn.tasks.pieces import Pieces
from lssd_learn.view.board import SHOWN, write_board
from lssd_learn.view.charts import collection_chart, pca_chart, spectrum_chart
from lssd_learn.view.painter import paint

PAINTED = 8


def write_overview(pieces: Pieces, out: Path, pictures: bool = False) -> None:
    """Fill the TensorBoard page of a run; with `pictures`, collection.png, spectrum.png and pca.png too."""
    pipeline, latent = pieces.pipeline, pieces.pipeline.latent
    operators = pipeline.operators(pieces.operators)
    embedding = pca(operators)
    labels = next(iter(pipeline.collection.groups.values()), None)
    write_board(
        out / "tensorboard",
        operators=operators[:, 0],
        names=pipeline.collection.names,
        spectrum=latent.spectrum,
        shape_spectra=latent.evals,
        points=embedding.points,
        ratios=embedding.ratios,
        labels=labels,
        shapes=previews(pipeline.collection, SHOWN, pipeline.cache),
        up=pipeline.collection.up,
    )
    if pictures:
        few = previews(pipeline.collection, PAINTED, pipeline.cache)
        painted = paint(few, up=pipeline.collection.up or "y", size=420)
        centred = (operators - operators.mean(0))[: len(few), 0]
        collection_chart(painted, centred, pipeline.collection.names[: len(few)]).savefig(out / "collection.png")
        spectrum_chart(latent.spectrum, latent.evals).savefig(out / "spectrum.png")
        names = pipeline.collection.names
        chart = pca_chart(embedding.points, embedding.ratios, labels, names, path=_is_chain(pipeline))
        chart.savefig(out / "pca.png")


def _is_chain(pipeline: Pipeline) -> bool:
    return getattr(pipeline.network, "func", None) == MapNetwork.chain
