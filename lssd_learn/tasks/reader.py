"""`task=reader`: make what `task=measure` reads body measures with, one file."""

import logging
from pathlib import Path

import numpy as np

from lssd_learn.cache import fingerprint
from lssd_learn.collections import People
from lssd_learn.collections.generated.skinned import BONES, LOOSE, some_turns
from lssd_learn.errors import InputError, check_whole
from lssd_learn.models.measuring import train_reader
from lssd_learn.models.measuring.scanned import kinds_of_scans, learnt_from
from lssd_learn.pieces import Pieces
from lssd_learn.written import write_columns

log = logging.getLogger(__name__)

FILE, TABLE = "reader.npz", "errors.csv"
KINDS = ("meshes", "clouds", "faulty")


def run(pieces: Pieces, out: Path, poses: int, scans: int, vertices: tuple[int, int], level: float) -> dict[str, float]:
    """Write reader.npz, and errors.csv: of each measure the mean absolute error on the scans that calibrate its
    intervals, and that of the mean person.

    Args:
        poses: in which bodies are tried on a scan.
        scans: of other people of the same kind, turned anyhow: a quarter meshes, a quarter clouds of 8,000 points, half
            meshes with faults.
        vertices: of a mesh, anywhere in between.
        level: of the intervals.

    Returns:
        "l1/…" of each measure of meshes without faults, in its unit, "clouds/…" and "faulty/…" the same of these.

    Raises:
        InputError: no people, numbers out of their range.
    """
    people, pipeline = pieces.pipeline.collection, pieces.pipeline
    if not isinstance(people, People) or not people.measures:
        raise InputError("task=reader: expected collection=people, and its measures")
    check_whole("task.poses", poses, 1)
    check_whole("task.scans", scans, 4)
    meshes, clouds, faulty = kinds_of_scans(people, scans, vertices)
    for each in (meshes, clouds, faulty):
        each.keep_in(pipeline.cache, pipeline.workers)
    turns = some_turns(poses, people.jitter, people.seed)
    key = None if people.key is None else fingerprint(people.key, turns.tolist(), LOOSE.tolist(), list(BONES))
    made = train_reader(
        learnt_from(people), turns, LOOSE, [meshes, clouds], [faulty], level, pipeline.cache, key, pipeline.workers
    )
    path, names = made.reader.save(out / FILE), made.reader.names
    errors = np.abs(made.read - made.truth)
    each = np.stack([errors[made.kinds == number].mean(axis=0) for number in range(len(KINDS))])
    columns = {kind: row.tolist() for kind, row in zip(KINDS, each, strict=True)}
    columns |= {"mean": np.abs(np.exp(made.reader.mean) - made.truth).mean(axis=0).tolist()}
    write_columns({"measure": list(names)} | columns, out / TABLE)
    log.info("%s (%.1f MB); mean absolute errors, meshes, clouds, faulty meshes:", path, path.stat().st_size / 1e6)
    for name, column in zip(names, each.T, strict=True):
        log.info("  %-20s %.4g %.4g %.4g", name, *column)
    told = zip(("l1", *KINDS[1:]), each, strict=True)
    return {f"{kind}/{name}": float(error) for kind, row in told for name, error in zip(names, row, strict=True)}
