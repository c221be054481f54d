"""`task=embed`: a collection at a glance, its operators as points in the plane."""

import logging
from pathlib import Path

import numpy as np

from lssd_learn.collections.groups import choose_group
from lssd_learn.errors import check_whole
from lssd_learn.exploration import base_shape_differences, pca, representatives, turning
from lssd_learn.exploration.surfaces.found import score_surfaces
from lssd_learn.pieces import Pieces
from lssd_learn.unsaid import warn_of_sides
from lssd_learn.view.embeddings import Panel, embedding_chart
from lssd_learn.view.sheets import shape_sheet
from lssd_learn.view.surfaces import surface_chart, write_surfaces
from lssd_learn.written import write_columns

log = logging.getLogger(__name__)

TABLE = "embedding.csv"


def run(
    pieces: Pieces,
    out: Path,
    group: str | None = None,
    dimensions: int = 2,
    base: int | None = None,
    shown: int = 8,
    azimuth: float = 20.0,
) -> dict[str, float]:
    """Write embedding.png, shapes.png and embedding.csv: name, groups and principal components, a row a shape; and the
    surfaces two standard deviations from the mean along each component, components.png and surfaces/.

    Each kind of operator has an embedding and columns of its own, as area_1, area_2. The shapes of a chain
    (network=chain) are joined by a line, and it is counted how often they go round.

    Args:
        group: what the points are coloured by; null is the first grouping, if there is any.
        dimensions: columns of each kind in the table, 2 or more.
        base: the position of a shape whose base-shape differences are embedded beside the others; None leaves them out.
        shown: shapes in shapes.png, spread over the collection.
        azimuth: degrees from which they are seen, see `paint`.

    Returns:
        "shapes" and the part of the variance along each axis, as area/1; of a chain area/turns and area/smallest_step,
        see `Turning`; of base-shape differences the same, as base_area/1.

    Raises:
        InputError: no such group or shape, arguments out of range.
    """
    check_whole("task.dimensions", dimensions, 2)
    check_whole("task.shown", shown, 1)
    if base is not None:
        check_whole("task.base", base, 0, len(pieces.pipeline.collection) - 1)
    pipeline = pieces.pipeline
    collection = pipeline.collection
    name = next(iter(collection.groups), None) if group is None else choose_group(collection, group, "task.group")
    labels = [None] * len(collection) if name is None else [str(label) for label in collection.groups[name]]
    operators = pipeline.operators(pieces.operators)
    warn_of_sides(collection, operators, pieces.operators, [] if name is None else [name])
    found = {kind: pca(operators[:, c], dimensions) for c, kind in enumerate(pieces.operators)}
    titles = {kind: f"{kind} operators" for kind in found}
    if base is not None:
        seen = base_shape_differences(pipeline.map_network(), base, pipeline.keep, pieces.operators)
        found |= {f"base_{kind}": pca(D, dimensions) for kind, D in zip(pieces.operators, seen, strict=True)}
        titles |= {f"base_{kind}": f"{kind} differences from {collection.names[base]}" for kind in pieces.operators}

    columns = {"name": collection.names, **collection.groups}
    for kind, embedding in found.items():
        columns |= {f"{kind}_{d + 1}": embedding.points[:, d].tolist() for d in range(dimensions)}
    write_columns(columns, out / TABLE)
    panels = [Panel(np.asarray(e.points)[:, :2], e.ratios, titles[kind]) for kind, e in found.items()]
    embedding_chart([panels], labels, collection.names, path=pipeline.in_order).savefig(out / "embedding.png")
    few = np.unique(np.linspace(0, len(collection) - 1, min(shown, len(collection))).round().astype(int)).tolist()
    row = {collection.names[int(i)]: collection[int(i)] for i in few}
    shape_sheet({"": row}, collection.up, azimuth, size=240).savefig(out / "shapes.png")
    scores = {f"{kind} PC{d + 1}": found[kind].points[:, d] for kind in pieces.operators for d in range(dimensions)}
    base_of, mirror = representatives(operators)[0], getattr(collection, "mirror", "auto")
    everyone, shape = np.arange(len(collection)), collection[base_of]
    surfaces = score_surfaces(pipeline.whole, everyone, scores, base_of, shape, mirror, pipeline.workers)
    lines = list(surfaces.components.values())
    write_surfaces(out / "surfaces", surfaces.lender, surfaces.mean, lines, collection.up)
    surface_chart(surfaces.lender, lines, collection.up, azimuth).savefig(out / "components.png")
    turned = (
        {kind: turning(e.points[:, :2]) for kind, e in found.items()}
        if pipeline.in_order and len(collection) > 2
        else {}
    )
    for kind, embedding in found.items():
        ratios = ", ".join(f"{ratio:.0%}" for ratio in embedding.ratios.tolist())
        log.info("%s: %s of the variance", titles[kind], ratios)
        if kind in turned:
            t = turned[kind]
            log.info("  in their order %.2f turns, the smallest step %.1f degrees", t.turns, t.smallest)
    log.info("%d shapes: embedding.csv, embedding.png, shapes.png, components.png, surfaces/", len(collection))
    ratios = {f"{kind}/{d + 1}": float(r) for kind, e in found.items() for d, r in enumerate(e.ratios)}
    rounds = {f"{kind}/turns": t.turns for kind, t in turned.items()}
    rounds |= {f"{kind}/smallest_step": t.smallest for kind, t in turned.items()}
    return {"shapes": len(collection), **ratios, **rounds}
