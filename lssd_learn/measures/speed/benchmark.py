"""`task=benchmark`: what every stage takes, beside a peer's implementation of the same where there is one.

Each measurement runs in a process of its own (`stopwatch.py`), ours and the peer's in turn; both are in `timed.py` and
`peer.py`. The peers are pyfmaps and, for the training, a bare loop in PyTorch.
"""

import logging
import statistics
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import cast

import numpy as np
from joblib import cpu_count

from lssd_learn import nets
from lssd_learn.collections.previews import previews
from lssd_learn.division.protocols import divide
from lssd_learn.errors import InputError
from lssd_learn.latent import MapNetwork
from lssd_learn.learning import ShapeData
from lssd_learn.measures.speed import peer, timed
from lssd_learn.measures.speed.stopwatch import Measured, Work, WorkFailedError, measure
from lssd_learn.measures.speed.timetable import BARE_LOOP, Row, growths, megabytes_at, render, with_exponents, write_csv
from lssd_learn.partials import unbound
from lssd_learn.pieces import Pieces
from lssd_learn.progress import duration, track
from lssd_learn.shapes import Mesh
from lssd_learn.view.charts import growth_chart

log = logging.getLogger(__name__)

BODIES = 8  # shapes whose eigenbases are timed: one a pose
FORETOLD = 100  # times as many shapes as were measured: nothing is said of more
CHEAP = 30.0  # seconds; what takes longer is measured once


def run(
    pieces: Pieces,
    out: Path,
    functions: Sequence[int],
    shapes: Sequence[int],
    peer_most: int,
    repeats: int,
    epochs: int,
    threads: int | None = None,
    foretell: int = 100_000,
) -> dict[str, float]:
    """Write benchmark.csv and benchmark.png, and the table to the log.

    Args:
        functions: numbers of eigenfunctions of one shape.
        shapes: numbers of shapes; of each, the network becomes a latent space and operators.
        peer_most: the most shapes the peer is asked for.
        repeats: measurements, of which the median counts; work over half a minute is done once.
        epochs: of the training.
        threads: of stages without a peer; None is one a core. Comparisons run on one thread each.
        foretell: number of shapes whose cost the log foretells from the growth, at most a hundred times those measured.

    Returns:
        "<stage>/" and seconds, megabytes, peer_seconds, peer_megabytes, ratio, difference, see `timetable.Row`, of
            eigenbasis/k50      the median over eight shapes;
            eigenbases/n60      shapes made or read, their eigenbases computed and stored, by all worker processes;
            network/n60         which shapes are mapped;
            latent/n60          that, maps, consistent and canonical basis, operators; difference is that of the
                                operators' eigenvalues;
            operators/n60       the operators alone;
            scaling/n60         the latent space and operators again, on `threads` threads;
            cache               the collection's operators read from the cache, against computing them;
            training            `learning.fit`, against a bare loop; here the ratio is ours over the loop's;
        and the growth of the seconds with n: "<stage>/exponent" of eigenbases, network, latent, operators and scaling,
        and latent/peer_exponent.

    Raises:
        InputError: an argument out of range, more shapes than there are, shapes not in vertex correspondence.
    """
    pipeline = pieces.pipeline
    threads = cpu_count() if threads is None else threads
    if pieces.debug.epochs is not None:  # each stage once, whatever was asked for
        shapes = [min(n, len(pipeline.collection)) for n in shapes]
        repeats, epochs, peer_most = 1, pieces.debug.epochs, min([peer_most, *shapes])
    shapes = sorted(set(shapes))
    workers = pipeline.workers or cpu_count()
    _check(shapes, len(pipeline.collection), functions, peer_most, repeats, epochs, threads, foretell)
    MapNetwork.clique(pipeline.bases)  # refuses shapes that are not in correspondence, before any long work
    if not peer.is_installed():
        log.info("the columns of the peer stay empty: pip install pyfmaps")

    some = previews(pipeline.collection, BODIES, pipeline.cache)
    stages = [partial(_eigenbasis, some, k, pipeline.laplacian, repeats) for k in functions]
    stages += [partial(_prepared, pieces, n, workers, out) for n in shapes]
    stages += [partial(_latent, pieces, n, n <= peer_most, repeats, threads) for n in shapes]
    if threads > 1:
        stages += [partial(_scaling, pieces, n, repeats, threads) for n in shapes]
    stages += [partial(_cache, pieces, threads), partial(_training, pieces, epochs, repeats)]
    rows = with_exponents([row for stage in track(stages, "stages measured") for row in stage()])

    growth = growths(rows)
    write_csv(rows, out / "benchmark.csv")
    named = {
        "eigenbases/exponent": f"eigenbases, {workers} process{'es' * (workers > 1)}",
        "network/exponent": "network, one thread",
        "latent/exponent": "latent space, one thread",
        "latent/peer_exponent": "pyfmaps, one thread",
        "scaling/exponent": f"latent space, {threads} threads",
        "operators/exponent": "operators, one thread",
    }
    if threads == 1:  # the same measurements
        named.pop("scaling/exponent")
    growth_chart({name: growth[key] for key, name in named.items() if key in growth}).savefig(out / "benchmark.png")
    vertices = len(pipeline.bases[0].mass)
    title = f"shapes of {vertices:,} vertices; latent: k {pipeline.k}, size {pipeline.size}, keep {pipeline.keep}"
    log.info("%s", render(rows, title))
    exponents = {name: curve.exponent for name, curve in growth.items() if curve.exponent is not None}
    far = shapes[-1] * FORETOLD >= foretell
    for key, name in named.items():
        if key in exponents:
            told = f"; of {foretell:,} shapes {duration(growth[key].at(foretell))}" if far else ""
            log.info("%s: seconds grow as n^%.2f%s", name, exponents[key], told)
    if far and len(shapes) > 1:
        log.info("latent space: memory of %s shapes %.2g GB", f"{foretell:,}", megabytes_at(rows, foretell) / 1000)
    elif not far:
        log.info("%s is too far from these shapes to foretell: task.shapes up to a hundredth", f"{foretell:,}")
    log.info("table and picture: benchmark.csv, benchmark.png")
    return {f"{row.stage}/{name}": number for row in rows for name, number in row.numbers().items()} | exponents


def _check(shapes, n, functions, peer_most, repeats, epochs, threads, foretell) -> None:
    if not shapes or not 2 <= shapes[0] <= shapes[-1] <= n:
        raise InputError(f"shapes={list(shapes)}: expected numbers from 2 to {n}, the shapes of the collection")
    if not functions or min(functions) < 1:
        raise InputError(f"functions={list(functions)}: expected numbers of eigenfunctions, 1 or more")
    for name, value, least in (
        ("peer_most", peer_most, 0), ("repeats", repeats, 1), ("epochs", epochs, 1), ("threads", threads, 1),
        ("foretell", foretell, 1),
    ):  # fmt: skip
        if value < least:
            raise InputError(f"{name}={value}: expected {least} or more")


def _eigenbasis(shapes: Sequence, k: int, laplacian: str, repeats: int) -> Iterator[Row]:
    comparable = peer.is_installed() and all(isinstance(shape, Mesh) for shape in shapes)
    theirs = partial(peer.eigenbases, shapes, k) if comparable else None
    ours, theirs = _in_turn(partial(timed.eigenbases, shapes, k, laplacian), theirs, repeats)
    yield _row(f"eigenbasis/k{k}", ours, theirs, lambda measured: measured.median)


def _prepared(pieces: Pieces, n: int, workers: int, out: Path) -> Iterator[Row]:
    pipeline = pieces.pipeline
    some = pipeline.collection[:n]
    # A copy in each process computes on one thread; the memory of those processes is not counted.
    work = partial(timed.prepared, some, pipeline.k, pipeline.laplacian, workers, out)
    got = measure(work, processor=workers == 1)
    yield Row(f"eigenbases/n{n}", workers, got.seconds)


def _latent(pieces: Pieces, n: int, with_peer: bool, repeats: int, threads: int) -> Iterator[Row]:
    pipeline, bases = pieces.pipeline, pieces.pipeline.bases[:n]
    with_peer = with_peer and peer.is_installed() and unbound(pipeline.network) == MapNetwork.clique
    theirs = partial(peer.latent, bases, pipeline.size, pipeline.keep) if with_peer else None
    ours, theirs = _in_turn(_ours(pieces, n), theirs, repeats)
    yield replace(_row(f"network/n{n}", ours, [], lambda measured: measured.laps["network"]), megabytes=None)
    row = _row(f"latent/n{n}", ours, theirs)
    if theirs:
        row = replace(row, difference=float(np.abs(ours[0].result - theirs[0].result).max()))
    yield row
    operators = _row(f"operators/n{n}", ours, theirs, lambda measured: measured.laps["operators"])
    yield replace(operators, megabytes=None, peer_megabytes=None)
    if threads == 1:  # as measured
        yield _row(f"scaling/n{n}", ours, [])


def _scaling(pieces: Pieces, n: int, repeats: int, threads: int) -> Iterator[Row]:
    ours, _ = _in_turn(_ours(pieces, n), None, repeats, threads)
    yield replace(_row(f"scaling/n{n}", ours, []), threads=threads)


def _ours(pieces: Pieces, n: int) -> Work:
    """The latent space of the first n shapes, by the run's own network."""
    pipeline = pieces.pipeline
    network = pipeline.network
    if pipeline.labels is not None:
        network = partial(network, labels=pipeline.labels[:n])
    return partial(timed.latent, pipeline.bases[:n], network, pipeline.size, pipeline.keep)


def _cache(pieces: Pieces, threads: int) -> Iterator[Row]:
    pipeline = pieces.pipeline
    if pipeline.cache is None or pipeline.collection.key is None:
        log.info("nothing of this collection is cached: reading it is not timed")
        return
    # A copy travels to the process without what this one has computed.
    got = measure(partial(timed.cached, replace(pipeline), pieces.operators), threads)
    read, compute = got.laps["read"], got.laps["compute"]
    yield Row("cache", threads, read, against="computing", peer_seconds=compute, peer_megabytes=got.megabytes)


def _training(pieces: Pieces, epochs: int, repeats: int) -> Iterator[Row]:
    collection, data = pieces.pipeline.collection, pieces.data
    if collection.parameters is None:
        log.info("the shapes have no parameters: training is not timed")
        return
    if nets.is_solved(pieces.net):
        log.info("a net that is solved in closed form takes no training steps: training is not timed")
        return
    clouds = nets.reads(pieces.net) == "clouds"
    inputs = pieces.pipeline.clouds(data.points) if clouds else pieces.pipeline.operators(pieces.operators).numpy()
    arguments = {
        "inputs": np.array(inputs),
        "targets": np.array(collection.parameters),
        "split": divide(collection, pieces.seed, data),
        "seed": pieces.seed,
        "batch": data.batch,
        "standardise": data.standardise,
        "standardise_targets": False,  # as the bare loop has it
    }
    shapes, epochs = ShapeData(**arguments), min(epochs, pieces.debug.epochs or epochs)
    parts = {name: shapes.part(name) for name in ("train", "validation")}
    parts |= {"mean": shapes.mean, "shape": {name: getattr(shapes, name) for name in ("channels", "size", "outputs")}}
    order = shapes.training().sampler
    batches = []
    for epoch in range(epochs):
        order.set_epoch(epoch)
        batches.append(list(order))
    rate = cast(float, pieces.learning_rate)
    ours, theirs = _in_turn(
        partial(timed.training, pieces.net, arguments, epochs, rate, pieces.seed),
        partial(peer.training, pieces.net, parts, batches, rate, pieces.seed),
        repeats,
    )
    row = _row("training", ours, theirs)
    difference = abs(ours[0].result - theirs[0].result)
    yield replace(row, against=BARE_LOOP, difference=difference)


def _in_turn(ours: Work, theirs: Work | None, repeats: int, threads: int = 1) -> tuple[list[Measured], list[Measured]]:
    """Measure ours, the peer's, ours, the peer's …, so that what else the machine does falls on both.

    On one thread the processor's seconds count, so that a busy machine makes neither slow; on several those that pass.

    The peer's side stays empty where its process fails, as it may for want of memory; what our own raises is raised.
    """
    clocked = partial(measure, threads=threads, processor=threads == 1)
    ours_took, theirs_took = [clocked(ours)], []
    if theirs is not None:
        try:
            theirs_took.append(clocked(theirs))
        except WorkFailedError as error:
            log.warning("the peer failed, %s", error)
            theirs = None
    for _ in range(repeats - 1):
        if ours_took[0].seconds < CHEAP:
            ours_took.append(clocked(ours))
        if theirs is not None and theirs_took[0].seconds < CHEAP:
            theirs_took.append(clocked(theirs))
    return ours_took, theirs_took


def _row(
    stage: str,
    ours: Sequence[Measured],
    theirs: Sequence[Measured],
    seconds: Callable[[Measured], float] = lambda measured: measured.seconds,
) -> Row:
    row = Row(stage, 1, *_medians(ours, seconds))
    if not theirs:
        return row
    took, megabytes = _medians(theirs, seconds)
    return replace(row, against="pyfmaps", peer_seconds=took, peer_megabytes=megabytes)


def _medians(measured: Sequence[Measured], seconds: Callable[[Measured], float]) -> tuple[float, float]:
    return statistics.median(map(seconds, measured)), statistics.median(m.megabytes for m in measured)
