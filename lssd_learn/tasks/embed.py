"""`task=embed`: a collection at a glance, its operators as points in the plane."""

import csv
import logging
from pathlib import Path

import numpy as np

from lssd_learn.errors import check_whole
from lssd_learn.exploration import pca
from lssd_learn.latent import MapNetwork
from lssd_learn.tasks.groups import choose_group
from lssd_learn.tasks.pieces import Pieces
from lssd_learn.view.embeddings import Panel, embedding_chart

log = logging.getLogger(__name__)

TABLE = "embedding.csv"


def run(pieces: Pieces, out: Path, group: str | None = None, dimensions: int = 2) -> dict[str, float]:
    """Write embedding.png and embedding.csv: name, groups and principal components, a row a shape.

    Each kind of operator has an embedding and columns of its own, as area_1, area_2.

    Args:
        group: what the points are coloured by; null is the first grouping, if there is any.
        dimensions: columns of each kind in the table, 2 or more.

    Returns:
        "shapes" and the part of the variance along each axis, as area/1.
    """
    check_whole("task.dimensions", dimensions, 2)
    pipeline = pieces.pipeline
    collection = pipeline.collection
    name = next(iter(collection.groups), None) if group is None else choose_group(collection, group, "task.group")
    labels = [None] * len(collection) if name is None else [str(label) for label in collection.groups[name]]
    operators = pipeline.operators(pieces.operators)
    found = {kind: pca(operators[:, c], dimensions) for c, kind in enumerate(pieces.operators)}

    columns = {"name": collection.names, **collection.groups}
    for kind, embedding in found.items():
        columns |= {f"{kind}_{d + 1}": [f"{x:.6g}" for x in embedding.points[:, d]] for d in range(dimensions)}
    with (out / TABLE).open("w", newline="", encoding="utf-8") as stream:
        table = csv.writer(stream)
        table.writerow(columns)
        table.writerows(zip(*columns.values(), strict=True))
    panels = [Panel(np.asarray(e.points)[:, :2], e.ratios, f"{kind} operators") for kind, e in found.items()]
    in_order = getattr(pipeline.network, "func", None) == MapNetwork.chain
    embedding_chart([panels], labels, collection.names, path=in_order).savefig(out / "embedding.png")
    for kind, embedding in found.items():
        log.info("%s: %s of the variance", kind, ", ".join(f"{ratio:.0%}" for ratio in embedding.ratios.tolist()))
    log.info("%d shapes: embedding.csv, embedding.png", len(collection))
    ratios = {f"{kind}/{d + 1}": float(r) for kind, e in found.items() for d, r in enumerate(e.ratios)}
    return {"shapes": len(collection), **ratios}
