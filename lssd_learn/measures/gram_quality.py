"""`task=gram_quality`: how near shapes come back that a latent space was not fitted to, from their Gram forms alone."""

import logging
from pathlib import Path

import numpy as np

from lssd_learn.division.protocols import divide
from lssd_learn.errors import InputError
from lssd_learn.latent import gram
from lssd_learn.operators import shapes_of_gram
from lssd_learn.pieces import Pieces
from lssd_learn.rows import write_columns
from lssd_learn.shapes.kabsch import kabsch

log = logging.getLogger(__name__)

TABLE = "gram_quality.csv"
WAYS = {
    "mean": "the mean of the fitted shapes",
    "nearest": "the fitted shape of the nearest Gram form",
    "smooth": "the smooth shape of its own",
    "detailed": "the smooth shape, with the detail of the nearest",
}


def run(pieces: Pieces, out: Path) -> dict[str, float]:
    """Write gram_quality.csv, a row a shape that is drawn; print how far off its vertices are, way by way.

    Drawn are the shapes the latent space was not fitted to, or, if `data.protocol` has a test that is pushed, this one.

    Distances to the true vertices, the mean over the vertices in the unit of length of the collection, after the best
    rotation and shift. No net is trained. What the ways are: `WAYS`.

    Returns:
        shapes, fitted, and <way>/mean and <way>/worst.

    Raises:
        InputError: latent.fitted leaves nothing to push; shapes that are not in vertex correspondence.
    """
    pipeline = pieces.pipeline
    n, collection = len(pipeline.collection), pipeline.collection
    some = np.array(range(n) if pipeline.fitted is None else pipeline.fitted)
    rest = np.setdiff1d(np.arange(n), some)
    if pieces.data.protocol != "transductive":
        rest = divide(collection, pieces.seed, pieces.data).test
    if not len(rest):
        raise InputError("task=gram_quality: expected latent.fitted=…, less than all shapes, so that some are drawn")
    if not pipeline.maps(pipeline.bases, collection).is_identity:
        raise InputError("task=gram_quality: expected shapes of the same faces, whose vertices can be compared")
    space, fitted = pipeline.latent, collection[some]
    mean = np.mean([shape.vertices for shape in fitted], axis=0)
    errors = {way: [] for way in WAYS}
    for i, laid in zip(rest, shapes_of_gram(gram(space.some(rest)), space.some(some), fitted), strict=True):
        drawn = mean, fitted[laid.nearest].vertices, laid.smooth, laid.vertices
        for way, vertices in zip(WAYS, drawn, strict=True):
            errors[way].append(vertex_error(vertices, collection[int(i)].vertices))
    metrics: dict[str, float] = {"shapes": len(rest), "fitted": len(some)}
    log.info("%d shapes from a space of %d others, vertices off by (mean, worst):", len(rest), len(some))
    for way, words in WAYS.items():
        metrics |= {f"{way}/mean": float(np.mean(errors[way])), f"{way}/worst": float(np.max(errors[way]))}
        log.info("  %-50s %.4g  %.4g", words, metrics[f"{way}/mean"], metrics[f"{way}/worst"])
    write_columns({"name": [collection.names[i] for i in rest]} | errors, out / TABLE)
    log.info("shape by shape: %s", out / TABLE)
    return metrics


def vertex_error(points: np.ndarray, truth: np.ndarray) -> float:
    """The mean distance of points (V, 3) to their true places (V, 3) after the best rotation and shift."""
    points, truth = (x - x.mean(axis=0) for x in (points, truth))
    return float(np.linalg.norm(points @ kabsch(points, truth) - truth, axis=1).mean())
