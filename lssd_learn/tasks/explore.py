"""`task=explore`: one page on which a shape follows sliders through the operators of a collection."""

import logging
from pathlib import Path

import numpy as np

from lssd_learn.collections.procrustes import centred_vertices, procrustes
from lssd_learn.errors import InputError
from lssd_learn.exploration.modes import shape_map
from lssd_learn.operators.vectors import live_functions, log_features
from lssd_learn.pieces import Pieces
from lssd_learn.shapes import Mesh
from lssd_learn.view.moving import most_modes
from lssd_learn.view.reports.explore import write_explorer

log = logging.getLogger(__name__)

PAGE = "explore.html"


def run(pieces: Pieces, out: Path, azimuth: float = 20.0) -> dict[str, float]:
    """Write explore.html: principal components, ways between shapes and analogies of operators, and the shape of them.

    Operators are turned into shapes by `exploration.modes.shape_map`, learnt of the collection at once. The page tells
    how far off the shapes are that had no part in it.

    Args:
        azimuth: degrees from which the shape is seen first, see `paint`.

    Returns:
        shapes; error and spread, mean vertex distances of left out shapes from what the map makes of their operators,
        and from the mean shape; megabytes.

    Raises:
        InputError: shapes that are not in vertex correspondence, fewer than three.
    """
    pipeline = pieces.pipeline
    collection, n = pipeline.collection, len(pipeline.collection)
    if not pipeline.maps(pipeline.bases, collection).is_identity:
        raise InputError("task=explore: expected shapes of the same faces, whose vertices can be moved")
    operators = pipeline.operators(pieces.operators)
    vertices = centred_vertices(collection)
    vertices = np.matmul(vertices, procrustes(vertices, np.arange(n)).astype(np.float32))
    first = collection[0]
    found = shape_map(
        log_features(operators, live_functions(operators)),
        vertices,
        modes=min(40, most_modes(len(first.vertices))),
        seed=pieces.seed,
    )
    kinds, known = ", ".join(pieces.operators), np.isfinite(found.error)
    summary = f"{n:,} shapes, moved through by their {kinds} operators."
    if known:
        summary += f" Shapes that had no part in it are drawn {found.error:.3g} off, in the mean; the mean shape is"
        summary += f" {found.spread:.3g} off."
    label = next(iter(collection.groups.values()), None)
    names = [name if label is None else f"{name}: {label[i]}" for i, name in enumerate(collection.names)]
    write_explorer(
        out / PAGE,
        title="A collection to move through",
        summary=summary,
        mean=Mesh(found.mean, first.faces) if isinstance(first, Mesh) else type(first)(found.mean),
        moves=found,
        names=names,
        footer=f"lssd_learn, task=explore; operators: {kinds}; {pipeline.keep} functions.",
        up=collection.up,
        azimuth=azimuth,
    )
    size = (out / PAGE).stat().st_size / 1e6
    log.info("%s %.1f MB: %s", summary, size, out / PAGE)
    return {"shapes": n, **({"error": found.error, "spread": found.spread} if known else {}), "megabytes": size}
