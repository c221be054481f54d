"""`task=reader`: train what `task=measure` reads body measures with, one small file."""

import logging
from pathlib import Path

import numpy as np

from lssd_learn.collections import People, Remeshed
from lssd_learn.collections.generated.measured import girth_loops
from lssd_learn.errors import InputError
from lssd_learn.models.measuring import train_reader
from lssd_learn.models.measuring.tapes import Loop
from lssd_learn.pieces import Pieces
from lssd_learn.rows import write_columns

log = logging.getLogger(__name__)

FILE, TABLE = "reader.npz", "errors.csv"


def run(
    pieces: Pieces, out: Path, references: int, scans: int, taught: int, vertices: tuple[int, int], level: float
) -> dict[str, float]:
    """Write reader.npz, and errors.csv: of each measure the mean absolute error on the scans it was calibrated on.

    Args:
        references, taught, level: see `train_reader`.
        scans: bodies of other people of the same kind, remeshed and turned, as scans come.
        vertices: of each, anywhere in between.

    Returns:
        "l1/…" of each measure, in its unit; "trusted", the part of scans whose maps can be.

    Raises:
        InputError: no people, numbers out of their range.
    """
    people = pieces.pipeline.collection
    if not isinstance(people, People) or not people.measures:
        raise InputError("task=reader: expected collection=people, and its measures")
    kind = {"jitter": people.jitter, "poses": people.poses, "ages": people.ages}
    others, twins = People(scans, people.seed + 1, **kind), People(scans, people.seed + 1, people.topology, **kind)
    wild = Remeshed(others, vertices=vertices, seed=people.seed, turned="any")
    pipeline = pieces.pipeline
    loops = {name: Loop(*loop) for name, loop in girth_loops(people.topology).items()}
    made = train_reader(people, wild, twins, references, taught, level, pipeline.cache, pipeline.workers, loops)
    path = made.reader.save(out / FILE)
    names, errors = made.reader.names, np.abs(made.read - made.truth).mean(0)
    widths = {"low": np.expm1(-made.reader.widths), "high": np.expm1(made.reader.widths)}
    columns = {"measure": names, "l1": errors.tolist()}
    write_columns(columns | {f"interval_{side}": some.tolist() for side, some in widths.items()}, out / TABLE)
    log.info("%s (%.1f MB); mean absolute errors on %d scans:", path, path.stat().st_size / 1e6, len(made.read))
    for name, error in zip(names, errors, strict=True):
        log.info("  %-20s %.4g", name, error)
    return {f"l1/{name}": float(error) for name, error in zip(names, errors, strict=True)} | {
        "trusted": float(made.trusted.mean())
    }
