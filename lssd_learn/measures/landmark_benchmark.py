"""`task=landmark_benchmark`: landmarks carried from a few shapes to others whose own are known."""

import logging
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from lssd_learn.collections.aligned import Aligned
from lssd_learn.collections.base import Collection
from lssd_learn.collections.checked import ensure_checked
from lssd_learn.collections.turned import Turned
from lssd_learn.errors import InputError, check_positive, check_whole
from lssd_learn.exploration.carrying import Asked, choose_hubs, landmarks_of
from lssd_learn.maps.carrying.carry import Carried
from lssd_learn.maps.carrying.consensus import consensus
from lssd_learn.measures.spline_reference import spline_errors
from lssd_learn.pieces import Pieces
from lssd_learn.pipeline import Pipeline
from lssd_learn.shapes import Mesh
from lssd_learn.tasks.landmarks import carry_all
from lssd_learn.view.landmarks.charts import benchmark_chart
from lssd_learn.written import write_rows

log = logging.getLogger(__name__)

TABLE, PICTURE = "landmark_errors.csv", "landmark_errors.png"
CHOICES = ("shape", "random")
TURNED = ("none", "any", "mirrored")
TOP = 0.1  # of the error bars, the largest


def run(
    pieces: Pieces,
    out: Path,
    hubs: int = 7,
    chosen: str = "shape",
    draws: int = 1,
    targets: int | None = None,
    turned: str = "none",
    far: float | None = None,
) -> dict[str, float]:
    """Carry the landmarks of some shapes to the others and compare; write landmark_errors.csv and a picture.

    Args:
        hubs: shapes whose landmarks are used.
        chosen: "shape", in the midst of the others, see `choose_hubs`; "random".
        draws: of hubs, where they are random.
        targets: so many of the others, drawn at random; None is all of them.
        turned: "none", shapes as they lie; "any", each turned at random; "mirrored", every second one mirrored too:
            they are then laid alike first, see `Aligned`.
        far: an error that a person would correct, in the units of the shapes; None is twice the mean.

    Returns:
        "error", "rms" and "median" over all landmarks of all draws, "error/area" over √area; "error/one", of single
        hubs; "error/N", of the first N hubs of each draw; "bars/correlation" of error bars and errors, "bars/found",
        the share of errors above `far` in the tenth of landmarks with the largest bars, "bars/mean" and "far", the
        share of such errors; "left_out", shapes without a map to be trusted; "spline", the error of a thin-plate spline
        from the same hubs that is told all other landmarks of a shape, and "error/spline", the ratio to it.

    Raises:
        InputError: a collection in which too few shapes have all landmarks, arguments out of range.
    """
    check_whole("task.draws", draws, 1)
    for name, value, choices in (("chosen", chosen, CHOICES), ("turned", turned, TURNED)):
        if value not in choices:
            raise InputError(f"task.{name}={value}: expected one of {', '.join(choices)}")
    if far is not None:
        check_positive("task.far", far)
    pipeline = _turned(pieces.pipeline, turned, pieces.seed)
    ensure_checked(pieces.pipeline.collection, pipeline.cache)
    given = landmarks_of(pipeline.collection)
    full = np.flatnonzero(given.counts == len(given.labels))
    check_whole("task.hubs", hubs, 1, len(full) - 1)
    if targets is not None:
        check_whole("task.targets", targets, 1, len(full) - hubs)
    rng, found, rows, hub_sets = np.random.default_rng(pieces.seed), [], [], []
    for draw in range(draws if chosen == "random" else 1):
        if chosen == "random":
            some = sorted(rng.permutation(full)[:hubs].tolist())
        else:
            some = choose_hubs(pipeline.bases, given, hubs)
        others = np.setdiff1d(full, some)
        if targets is not None:
            others = np.sort(rng.permutation(others)[:targets])
        hub_sets.append(some)
        found.append(carry_all(pipeline, given, some, others.tolist()))
        rows += _rows(given, found[-1], draw)
        log.info("hubs: %s", ", ".join(given.collection.names[h] for h in some))
    write_rows(rows, out / TABLE)
    errors = np.concatenate([_errors(given, one) for one in found])
    kept = ~np.isnan(errors).all(axis=1)
    if not kept.any():
        raise InputError("task=landmark_benchmark: none of the maps is to be trusted; there is nothing to score")
    errors, bars = errors[kept], np.concatenate([one.bars for one in found])[kept]
    sizes = np.concatenate([_sizes(given.collection, one.shapes) for one in found])[kept]
    limit = 2 * float(np.nanmean(errors)) if far is None else float(far)
    by_count, spline = _by_count(given, found), _spline(given, hub_sets, found)
    metrics = {
        "error": np.nanmean(errors),
        "rms": np.sqrt(np.nanmean(errors**2)),
        "median": np.nanmedian(errors),
        "error/area": np.nanmean(errors / sizes[:, None]),
        "far": np.mean(errors[np.isfinite(errors)] > limit),
        "left_out": sum(len(one.lost) for one in found),
        "settled": np.mean([one.is_settled for one in found]),
        **{f"error/{count}": error for count, error in by_count.items()},
        **({} if spline is None else {"spline": spline, "error/spline": np.nanmean(errors) / spline}),
        **_bars(errors, bars, limit),
    }
    by_label = np.nanmean(errors, axis=0)
    benchmark_chart(given.labels, errors, bars, by_count).savefig(out / PICTURE, dpi=150)
    for label, error in zip(given.labels, by_label, strict=True):
        log.info("%-16s error %.4g", label, error)
    log.info("%d landmarks, mean error %.4g: %s, %s", np.isfinite(errors).sum(), metrics["error"], TABLE, PICTURE)
    return {name: float(value) for name, value in metrics.items()}


def _turned(pipeline: Pipeline, turned: str, seed: int) -> Pipeline:
    """The same with the shapes lying anyhow."""
    if turned == "none":
        return pipeline
    collection = pipeline.collection
    base = collection.collection if isinstance(collection, Aligned) else collection
    lying = Turned(base, turned == "mirrored", seed)
    return replace(pipeline, collection=Aligned(lying) if turned == "mirrored" else lying)


def _errors(given: Asked, found: Carried) -> np.ndarray:
    """(m, L) distances from the known landmarks."""
    return np.linalg.norm(found.points - given.points[found.shapes], axis=2)


def _sizes(collection: Collection, shapes: Sequence[int]) -> np.ndarray:
    """(m,) √area."""
    return np.sqrt([shape.area for shape in (collection[i] for i in shapes) if isinstance(shape, Mesh)])


def _rows(given: Asked, found: Carried, draw: int) -> list[dict[str, object]]:
    """A row a landmark of a shape."""
    names = given.collection.names
    return [
        {"draw": draw, "name": names[i], "landmark": label, "error": error, "bar": bar, "spread": spread}
        for i, one, own, bars in zip(found.shapes, found.found, _errors(given, found), found.bars, strict=True)
        for label, error, bar, spread in zip(
            given.labels, own.tolist(), bars.tolist(), one.spread.tolist(), strict=True
        )
    ]


def _by_count(given: Asked, found: Sequence[Carried]) -> dict[int, float]:
    """Number of hubs → mean error of what the first of them say; of one it is that of each by itself."""
    hubs = found[0].places.shape[1]
    errors: dict[int, list[np.ndarray]] = {count: [] for count in sorted({1, *range(3, hubs, 2), hubs})}
    for one in found:
        for i, places in zip(one.shapes, one.places, strict=True):
            for count, series in errors.items():
                said = places if count == 1 else consensus(places[:count]).points[None]
                series.append(np.linalg.norm(said - given.points[i], axis=2).ravel())
    return {count: float(np.nanmean(np.concatenate(series))) for count, series in errors.items()}


def _spline(given: Asked, hub_sets: Sequence[Sequence[int]], found: Sequence[Carried]) -> float | None:
    """Mean error of `spline_errors` on the shapes that have got landmarks; None where there is none."""
    errors = []
    for hubs, one in zip(hub_sets, found, strict=True):
        some = np.setdiff1d(one.shapes, one.lost)
        errors.append(spline_errors(given.points[list(hubs)], given.points[some]))
    known = [error for error in errors if error is not None]
    return float(np.mean(np.concatenate(known))) if known else None


def _bars(errors: np.ndarray, bars: np.ndarray, limit: float) -> dict[str, float]:
    """What the error bars (m, L) tell of the errors (m, L)."""
    here = np.isfinite(errors) & np.isfinite(bars)
    e, b = errors[here], bars[here]
    if len(e) < 2:
        return {}
    largest = np.zeros(len(b), dtype=bool)
    largest[np.argsort(-b, kind="stable")[: max(1, round(TOP * len(b)))]] = True
    spread = e.std() * b.std()
    told = {"bars/mean": b.mean(), "bars/rms_ratio": np.sqrt(np.mean(e**2) / np.mean(b**2))}
    if spread > 0:
        told["bars/correlation"] = np.mean((e - e.mean()) * (b - b.mean())) / spread
    if (e > limit).any():
        told["bars/found"] = np.mean(largest[e > limit])
    return told
