"""`task=interpolation`: a path of operators from one shape to another, drawn by a trained reconstruction."""

import logging
from pathlib import Path
from typing import cast

import numpy as np
import torch

from lssd_learn.errors import check_whole
from lssd_learn.models.synthesis import channelwise, choose, draw_points, open_trained, operators_of
from lssd_learn.operators import interpolate
from lssd_learn.pieces import Pieces
from lssd_learn.shapes import Shape
from lssd_learn.view.exports import export
from lssd_learn.view.sheets import shape_sheet, write_sheets

log = logging.getLogger(__name__)

METHODS = ("linear", "log_euclidean")


@torch.no_grad()
def run(
    pieces: Pieces, out: Path, a: str, b: str, steps: int = 9, neighbours: int = 5, local: bool = False
) -> dict[str, float]:
    """Write interpolation.png, a strip a path, and the shapes of each path in a folder of its name.

    Args:
        a, b: names of shapes of the collection; of generated bodies also with a pose, as body_0003:sitting.
        steps: shapes of a path, those drawn of A and B among them.
        neighbours: training shapes that a new one is pushed from.
        local: see `open_trained`.

    Returns:
        Of each path the numbers of `smoothness`, as linear/step_ratio.

    Raises:
        InputError: see `open_trained`, `choose`, `operators_of`.
    """
    check_whole("task.steps", steps, 3)
    collection = pieces.pipeline.collection
    trained = open_trained(pieces.ckpt_path, pieces.net, pieces.pipeline.cache, "interpolation", local)
    chosen = choose(collection, {"task.a": a, "task.b": b})
    D, E = operators_of(trained, chosen, pieces.pipeline, neighbours)
    times = torch.linspace(0, 1, steps, dtype=torch.float64)
    titles = [f"{t:.2f}".rstrip("0").rstrip(".") for t in times.tolist()]
    truth = dict.fromkeys(titles) | dict(zip((titles[0], titles[-1]), chosen, strict=True))
    rows, metrics = {"truth": truth}, {}
    log.info("  %-16s %12s %12s %12s %12s", "", "length mm", "step mm", "step ratio", "progress")
    for method in METHODS:
        # The ends are broadcast: `channelwise` cuts along the second axis, which the steps would otherwise take.
        path = channelwise(lambda X, Y, how=method: interpolate(X[0], Y[0], times, how), D[None], E[None])
        drawn = draw_points(trained.learner, path)
        found = smoothness(drawn.double().numpy())
        metrics |= {f"{method}/{key}": value for key, value in found.items()}
        cells = found["length_mm"], found["longest_mm"], found["step_ratio"], found["progress"]
        log.info("  %-16s %12.1f %12.1f %12.2f %12.0f%%", method, *cells[:3], 100 * cells[3])
        shapes = trained.to_shapes(drawn)
        rows[method] = dict(zip(titles, shapes, strict=True))
        for i, shape in enumerate(shapes):
            export(shape, out / method, f"{i:02d}", collection.up)
    sheet = shape_sheet(rows, collection.up)
    sheet.savefig(out / "interpolation.png")
    scenes = {f"interpolation/{m}": [cast(Shape, shape) for shape in rows[m].values()] for m in METHODS}
    write_sheets(out / "tensorboard", {"interpolation/sheet": sheet}, scenes, collection.up)
    log.info("from %s to %s in %d steps: interpolation.png; PLY and GLB: linear/, log_euclidean/", *chosen.names, steps)
    return metrics


def smoothness(path: np.ndarray) -> dict[str, float]:
    """How evenly points move along a path.

    Args:
        path: (s, N, 3) in metres; point i of one shape is point i of the next.

    Returns:
        length_mm: the sum of the steps, each the mean distance the points move.
        longest_mm: the longest step.
        step_ratio: the longest over the shortest; 1 is even.
        progress: the part of the steps that lead on from the first shape to the last, by d / (d + d'), with d and d'
            the mean distances of the points to where they are in the first and in the last.
    """

    def moved(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        return np.linalg.norm(x - y, axis=-1).mean(-1)

    steps, total = moved(path[1:], path[:-1]), moved(path, path[:1]) + moved(path, path[-1:])
    done = moved(path, path[:1]) / np.maximum(total, np.finfo(float).tiny)
    shortest = max(steps.min(), np.finfo(np.float32).tiny)
    return {
        "length_mm": float(1000 * steps.sum()),
        "longest_mm": float(1000 * steps.max()),
        "step_ratio": float(steps.max() / shortest),
        "progress": float(np.mean(np.diff(done) > 0)),
    }
