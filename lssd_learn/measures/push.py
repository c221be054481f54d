"""`task=push`: a latent space of some shapes into which the others are pushed, beside the space of all of them.

The paper fits 400 of 2,560 shapes and pushes the rest, for the time it takes. What that saves, and what it changes.
"""

import logging
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np
import torch
from torch import Tensor

from lssd_learn.errors import InputError, check_whole
from lssd_learn.latent import LatentSpace
from lssd_learn.latent.differences import stack_differences
from lssd_learn.latent.newcomers import push_all
from lssd_learn.latent.orthogonal import nearest_orthogonal
from lssd_learn.pieces import Pieces
from lssd_learn.pipeline import Pipeline
from lssd_learn.written import write_columns

log = logging.getLogger(__name__)

TABLE = "push.csv"
CHANGES = ("orthogonal", "normalised")


def run(pieces: Pieces, out: Path, neighbours: int = 5) -> dict[str, float]:
    """Write push.csv, a row a shape; print what each way takes and by how much its operators differ from those of all.

    The ways: "least_squares" over the neighbours, and "nearest", from one of them, as in the paper. A space of some
    shapes has another basis than one of all, and another average shape. So it is compared after the change of basis
    that suits all shapes best: an orthogonal one leaves the difference of the averages; a normalised one makes the mean
    area operator of all shapes the identity first, as a fit to all does. Differences are in parts of the collection's
    spread, the root mean square of ‖D − mean D‖.

    Args:
        neighbours: fitted shapes that each of the others is pushed from by least squares.

    Returns:
        seconds/<lap> and cpu_seconds/<lap> of the laps all, some, least_squares and nearest: the fit to all shapes and
        to some, the pushes of the rest; eigenbases are taken as given. <way>/<change>/<who>/mean and worst: who is
        "fitted" (in all ways the same) or "pushed".

    Raises:
        InputError: latent.fitted leaves nothing to push; shapes that are not in vertex correspondence.
    """
    check_whole("task.neighbours", neighbours, 1)
    pipeline = pieces.pipeline
    n = len(pipeline.collection)
    some = np.array(range(n) if pipeline.fitted is None else pipeline.fitted)
    rest = np.setdiff1d(np.arange(n), some)
    if not len(rest):
        raise InputError("task=push: expected latent.fitted=…, less than all shapes, so that some are pushed")
    if not pipeline.maps(pipeline.bases, pipeline.collection).is_identity:
        raise InputError("task=push: expected shapes of the same faces, since they are pushed by them")
    clock = _Clock()
    whole = clock.lap("all", lambda: _fit(pipeline, range(n)))
    part = clock.lap("some", lambda: _fit(pipeline, some))
    Ys, names = {}, [pipeline.collection.names[int(i)] for i in rest]
    for way, number in (("least_squares", neighbours), ("nearest", 1)):
        pushed = clock.lap(way, lambda w=way, p=number: push_all(part, pipeline.bases[rest], names, p, w))
        Ys[way] = torch.empty_like(whole.Y)
        Ys[way][some], Ys[way][rest] = part.Y, pushed.Y

    wanted = stack_differences(whole, pieces.operators)
    spread = (wanted - wanted.mean(0)).flatten(1).square().sum(1).mean().sqrt()
    differences = {}
    for way, Y in Ys.items():
        for change in CHANGES:
            moved = stack_differences(
                whole.with_shapes(_changed(Y, whole.Y, change), whole.evals, whole.bases), pieces.operators
            )
            differences[way, change] = ((moved - wanted).flatten(1).norm(dim=1) / spread).numpy()
    columns = {"name": pipeline.collection.names, "fitted": np.isin(range(n), some).astype(int).tolist()}
    columns |= {f"{way}_{change}": values.tolist() for (way, change), values in differences.items()}
    write_columns(columns, out / TABLE)
    metrics = {"shapes": n, "fitted": len(some), **clock.metrics()}
    for (way, change), values in differences.items():
        for who, where in (("fitted", some), ("pushed", rest)):
            metrics |= {f"{way}/{change}/{who}/mean": float(values[where].mean())}
            metrics |= {f"{way}/{change}/{who}/worst": float(values[where].max())}
    _tell(metrics, len(rest))
    return metrics


def _fit(pipeline: Pipeline, positions: Sequence[int] | np.ndarray) -> LatentSpace:
    """Not from the cache: the time counts."""
    return LatentSpace.fit(pipeline.map_network(positions), pipeline.size, pipeline.keep)


def _changed(Y: Tensor, wanted: Tensor, change: str) -> Tensor:
    """The bases (n, k, m) after the change of basis that brings them nearest to those wanted (n, k, m)."""
    if change == "normalised":
        evals, V = torch.linalg.eigh(torch.einsum("nki,nkj->ij", Y, Y) / len(Y))
        Y = Y @ ((V * evals**-0.5) @ V.T)
    return Y @ nearest_orthogonal(torch.einsum("nki,nkj->ij", Y, wanted))


class _Clock:
    def __init__(self):
        self.laps: dict[str, tuple[float, float]] = {}

    def lap(self, name: str, work: Callable[[], LatentSpace]) -> LatentSpace:
        wall, cpu = time.perf_counter(), time.process_time()
        result = work()
        self.laps[name] = time.perf_counter() - wall, time.process_time() - cpu
        return result

    def metrics(self) -> dict[str, float]:
        seconds = {f"seconds/{name}": wall for name, (wall, _) in self.laps.items()}
        return seconds | {f"cpu_seconds/{name}": cpu for name, (_, cpu) in self.laps.items()}


def _tell(metrics: Mapping[str, float], pushed: int) -> None:
    log.info("%d shapes fitted, %d pushed; seconds of processor time (by the clock):", metrics["fitted"], pushed)
    for lap, what in (("all", "fit to all"), ("some", "fit to some"), ("least_squares", "push the rest by"),
                      ("nearest", "push the rest from the")):  # fmt: skip
        words = f"{what} {lap.replace('_', ' ')}" if what.startswith("push") else what
        log.info("  %-32s %7.1f (%.1f)", words, metrics[f"cpu_seconds/{lap}"], metrics[f"seconds/{lap}"])
    log.info("operators beside those of the fit to all, in parts of the spread: mean (worst)")
    log.info("  %-16s %-12s %18s %18s", "", "up to", "fitted", "pushed")
    for way in ("least_squares", "nearest"):
        for change in CHANGES:
            cells = [
                "{:.2%} ({:.2%})".format(*(metrics[f"{way}/{change}/{who}/{what}"] for what in ("mean", "worst")))
                for who in ("fitted", "pushed")
            ]
            log.info("  %-16s %-12s %18s %18s", way.replace("_", " "), change, *cells)
    log.info("push.csv: the same of every shape")
