"""`task=inversion_quality`: how near optimisation comes to shapes from their operators alone, from other shapes."""

import logging
import time
from collections.abc import Sequence
from pathlib import Path
from typing import cast

import numpy as np

from lssd_learn.collections.groups import read_labels
from lssd_learn.division.protocols import divide
from lssd_learn.errors import InputError, check_whole
from lssd_learn.latent.differences import stack_differences
from lssd_learn.operators import functions_of, shape_of_operators
from lssd_learn.pieces import Pieces
from lssd_learn.progress import track
from lssd_learn.shapes import Mesh
from lssd_learn.shapes.kabsch import vertex_error
from lssd_learn.written import write_rows

log = logging.getLogger(__name__)

TABLE = "inversion_quality.csv"
NEIGHBOURS = 5  # shapes that the functions of what is drawn are pushed from


def run(
    pieces: Pieces, out: Path, labels: Sequence[str] | None = None, group: str = "pose", shapes: int = 10
) -> dict[str, float]:
    """Write inversion_quality.csv, a row a shape: how far off its start is, and what was found.

    Sought are shapes that the latent space was not fitted to, from their operators (`latent.operators`). Each search
    starts at a fitted shape drawn at random, of the same label. Distances to the true vertices, the mean over the
    vertices in the unit of length of the collection, after the best rotation and shift.

    Args:
        labels: of the group whose shapes are sought by turns.
        group: its name.
        shapes: how many, at most.

    Returns:
        shapes, start/mean, found/mean, found/worst, seconds/mean and seconds/worst of processor time; and for each
            label found/<label>.

    Raises:
        InputError: latent.fitted leaves nothing to seek; shapes that are not in vertex correspondence; no such label.
    """
    check_whole("task.shapes", shapes, 1)
    pipeline, collection = pieces.pipeline, pieces.pipeline.collection
    some = np.arange(len(collection)) if pipeline.fitted is None else np.asarray(pipeline.fitted)
    rest = np.setdiff1d(np.arange(len(collection)), some)
    if pieces.data.protocol != "transductive":
        rest = divide(collection, pieces.seed, pieces.data).test
    if not len(rest):
        raise InputError(
            "task=inversion_quality: expected latent.fitted=…, less than all shapes, so that some are sought"
        )
    if not pipeline.maps(pipeline.bases, collection).is_identity or not isinstance(collection[0], Mesh):
        raise InputError("task=inversion_quality: expected meshes of the same faces, whose vertices can be compared")
    named = np.array(read_labels(collection, group, "task.group")).astype(str)
    asked = list(dict.fromkeys(named)) if labels is None else [str(label) for label in labels]
    for label in asked:
        if label not in named[rest] or label not in named[some]:
            raise InputError(f"task.labels={label}: expected a {group} of shapes fitted and not")
    turns = [rest[named[rest] == label] for label in asked]
    order = [int(of[i]) for i in range(max(map(len, turns))) for of in turns if i < len(of)][:shapes]
    space, rng, rows = pipeline.latent, np.random.default_rng([pieces.seed, 6]), []
    wanted, fitted = stack_differences(space.some(order), pieces.operators).double(), space.some(some)
    known = stack_differences(fitted, pieces.operators).double()
    faces = cast(Mesh, collection[0]).faces
    for i, operators in zip(track(order, "shapes of operators"), wanted, strict=True):
        start, truth = collection[int(rng.choice(some[named[some] == named[i]]))], collection[i]
        near = (known - operators).square().flatten(1).sum(1).argsort()[:NEIGHBOURS].tolist()
        began = time.process_time()
        functions = functions_of(fitted, faces, near)
        found = shape_of_operators(operators, start.vertices, faces, functions, fitted.seen, pieces.operators)
        seconds = time.process_time() - began
        errors = {
            "start": vertex_error(start.vertices, truth.vertices),
            "found": vertex_error(found.vertices, truth.vertices),
        }
        rows.append({"name": collection.names[i], group: named[i]} | errors | {"seconds": seconds})
    write_rows(rows, out / TABLE)
    column = {name: np.array([row[name] for row in rows]) for name in ("start", "found", "seconds")}
    metrics = {"shapes": float(len(rows)), "start/mean": float(column["start"].mean())}
    for name in ("found", "seconds"):
        metrics |= {f"{name}/mean": float(column[name].mean()), f"{name}/worst": float(column[name].max())}
    told = [str(row[group]) for row in rows]
    metrics |= {
        f"found/{label}": float(column["found"][[t == label for t in told]].mean()) for label in asked if label in told
    }
    log.info(
        "%d shapes, vertices off by %.4g (worst %.4g), the starts by %.4g; %.1f s each: %s",
        len(rows),
        *(metrics[key] for key in ("found/mean", "found/worst", "start/mean", "seconds/mean")),
        out / TABLE,
    )
    return metrics
