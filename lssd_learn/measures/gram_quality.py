"""`task=gram_quality`: how near shapes come back that a latent space was not fitted to, from their Gram forms alone."""

import logging
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from lssd_learn.collections import Bodies
from lssd_learn.division.protocols import divide
from lssd_learn.errors import InputError
from lssd_learn.latent import LatentSpace, gram
from lssd_learn.latent.newcomers import push_all
from lssd_learn.operators import moved_alike, shapes_of_gram
from lssd_learn.pieces import Pieces
from lssd_learn.progress import track
from lssd_learn.shapes import Mesh, Shape
from lssd_learn.shapes.eigenbasis import eigenbasis_as_is
from lssd_learn.shapes.kabsch import vertex_error
from lssd_learn.written import write_columns

log = logging.getLogger(__name__)

TABLE = "gram_quality.csv"
WAYS = {
    "mean": "the mean of the fitted shapes",
    "nearest": "the fitted shape of the nearest Gram form",
    "smooth": "the smooth shape of its own",
    "detailed": "the smooth shape, with the detail of the nearest",
}


def run(pieces: Pieces, out: Path, analogies: int = 0) -> dict[str, float]:
    """Write gram_quality.csv, a row a shape that is drawn; print how far off its vertices are, way by way.

    Drawn are the shapes the latent space was not fitted to, or, if `data.protocol` has a test that is pushed, this one.

    Distances to the true vertices, the mean over the vertices in the unit of length of the collection, after the best
    rotation and shift. No net is trained. What the ways are: `WAYS`.

    Of generated bodies, analogies too: A is one of those drawn and the truth another; B is the first body in the pose
    of the second, and C the second in that of the first. All are known by their Gram forms alone, and drawn; C then
    moves as A does to B, see `moved_alike`.

    Args:
        analogies: how many.

    Returns:
        shapes, fitted, and <way>/mean and <way>/worst. Of analogies analogy/mean and analogy/worst, and beside them
        analogy/own, how far off the truth is of its own form, analogy/C, and analogy/exact, of A, B and C as they are.

    Raises:
        InputError: latent.fitted leaves nothing to push; shapes that are not in vertex correspondence; analogies of
            others than bodies.
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
    return metrics | (_analogies(pieces, rest, space.some(some), fitted, analogies) if analogies else {})


def _analogies(
    pieces: Pieces, rest: np.ndarray, space: LatentSpace, fitted: Sequence[Shape], count: int
) -> dict[str, float]:
    bodies, rng, errors = pieces.pipeline.collection, np.random.default_rng([pieces.seed, 5]), []
    if not isinstance(bodies, Bodies) or bodies.jitter:
        raise InputError(f"task.analogies={count}: expected collection=bodies without jitter, which has the answers")
    for _ in track(range(count), "analogies"):
        i, j = map(int, rng.choice(rest, 2, replace=False))
        four = [bodies.make(bodies.sliders[x], bodies.pose(y)) for x, y in ((i, i), (i, j), (j, i), (j, j))]
        bases = [eigenbasis_as_is(shape, pieces.pipeline.k, pieces.pipeline.laplacian) for shape in four]
        forms = gram(push_all(space, bases, ["A", "B", "C", "the truth"]))
        A, B, C, own = (laid.vertices for laid in shapes_of_gram(forms, space, fitted))
        found = moved_alike(Mesh(C, four[2].faces), A, B)
        exact = moved_alike(four[2], four[0].vertices, four[1].vertices)
        errors.append([vertex_error(x, four[3].vertices) for x in (found, own, four[2].vertices, exact)])
    (mean, own, other, exact), worst = np.mean(errors, axis=0), np.max(errors, axis=0)[0]
    told = (
        "%d analogies, vertices off by %.4g (worst %.4g), of A, B and C as they are %.4g; of its own form %.4g, C %.4g"
    )
    log.info(told, count, mean, worst, exact, own, other)
    return {
        "analogy/mean": mean,
        "analogy/worst": worst,
        "analogy/own": own,
        "analogy/C": other,
        "analogy/exact": exact,
    }
