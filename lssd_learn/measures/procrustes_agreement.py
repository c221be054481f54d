"""`task=procrustes_agreement`: do operators tell shapes apart as Procrustes analysis of their landmarks does?"""

import logging
from pathlib import Path

import numpy as np

from lssd_learn.errors import check_whole
from lssd_learn.exploration.mantel import distances, mantel
from lssd_learn.exploration.models.vectors import model_vectors, scores
from lssd_learn.exploration.template import aligned_landmarks
from lssd_learn.maps.common_landmarks import common_landmarks
from lssd_learn.pieces import Pieces
from lssd_learn.written import write_rows

log = logging.getLogger(__name__)

TABLE = "agreement.csv"
SCALED = {"size and shape": False, "shape": True}  # landmarks as they are, and of centroid size one


def run(pieces: Pieces, out: Path, permutations: int = 999) -> dict[str, float]:
    """Write agreement.csv: a row a kind of operator and a kind of Procrustes analysis.

    Args:
        permutations: of Mantel's test.

    Returns:
        area/shape/mantel, the correlation of the distances between shapes, area/shape/p of Mantel's test, and
        area/shape/first, the size of the correlation of the first principal components; area/size and shape/mantel,
        with the size of the landmarks, and so on.

    Raises:
        InputError: landmarks that not all shapes have; arguments out of range.
    """
    check_whole("task.permutations", permutations, 19)
    pipeline, kinds = pieces.pipeline, list(pieces.operators)
    collection = pipeline.collection
    vertices = common_landmarks(collection)
    marks = np.stack([shape.vertices[some] for shape, some in zip(collection, vertices, strict=True)])
    _, _ = pipeline.latent, pipeline.bases
    vectors = model_vectors(pipeline.operators(kinds), kinds)
    rows = []
    for how, scale in SCALED.items():
        other = scores(aligned_landmarks(marks, scale).reshape(len(marks), -1))
        for kind, Y in vectors.items():
            found = mantel(distances(Y), distances(other), permutations, pieces.seed)
            first = abs(float(np.corrcoef(Y[:, 0], other[:, 0])[0, 1]))
            rows.append({"operator": kind, "landmarks": how, "mantel": found.correlation, "p": found.p, "first": first})
    write_rows([{"shapes": len(marks), "of them": vertices.shape[1]} | row for row in rows], out / TABLE)
    for row in rows:
        log.info("  %-16s %-15s Mantel %.3f, p %.3f; first components %.3f", *list(row.values()))
    log.info(TABLE)
    return {f"{row['operator']}/{row['landmarks']}/{key}": row[key] for row in rows for key in ("mantel", "p", "first")}
