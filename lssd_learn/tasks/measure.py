"""`task=measure`: centimetres of the people in a folder of scans, by the reader that `task=reader` has made."""

import logging
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from lssd_learn.collections import Collection
from lssd_learn.errors import InputError
from lssd_learn.models.measuring import BodyReader, Reading
from lssd_learn.models.measuring.picture import save_pictures
from lssd_learn.models.measuring.report import write_report
from lssd_learn.models.measuring.table import read_all, told, write_table
from lssd_learn.pieces import Pieces

log = logging.getLogger(__name__)


def run(pieces: Pieces, out: Path, reader: str | None, unit: str = "auto", pictures: bool = True) -> dict[str, float]:
    """Write measures.csv and measures.json: each measure of each scan with an interval, in millimetres; and pictures/,
    each scan with the tapes on it, and report.html, all of it as a page.

    Args:
        reader: a file that `task=reader` has written; None is the one that comes with the package.
        unit: of the scans: m, cm, mm, or auto, which finds out, scan by scan.
        pictures: whether there are any, and a page.

    Returns:
        "shapes", how many were read, "refused", how many were not, which the log says of each, and "signs", how many
        show a fault. Of a collection whose measures are known also "l1/…", the mean absolute error of each in its unit,
        "mean/…" the same of the mean of the people it learnt from, and "held", the part of intervals that hold.

    Raises:
        InputError: no such reader, no scan that can be read.
    """
    known = BodyReader.load() if reader is None else BodyReader.load(Path(reader).expanduser())
    found, refused = read_all(known, pieces.pipeline.collection, unit)
    for line in refused:
        log.warning("%s", line)
    if not found:
        raise InputError(f"none of {len(refused)} scans can be read; the first: {refused[0]}")
    for line in told(known, found):
        log.info("%s", line)
    for name in ("measures.csv", "measures.json"):
        write_table(known, found, out / name)
    if pictures:
        save_pictures(known, pieces.pipeline.collection, found, out / "pictures")
        write_report(known, pieces.pipeline.collection, found, refused, out / "report.html")
    signs = sum(bool(one.signs) for one in found.values())
    counts = {"shapes": len(found), "refused": len(refused), "signs": signs}
    return counts | _scored(known, found, pieces.pipeline.collection)


def _scored(reader: BodyReader, found: Mapping[str, Reading], collection: Collection) -> dict[str, float]:
    """Errors by measure, where the measures of the collection are known."""
    if collection.parameters is None or list(collection.parameter_names) != list(reader.names):
        return {}
    place = {name: i for i, name in enumerate(collection.names)}
    truth = collection.parameters[[place[name] for name in found]]
    read, low, high = (np.stack([getattr(one, what) for one in found.values()]) for what in ("values", "low", "high"))
    metrics = {"held": float(((low <= truth) & (truth <= high)).mean())}
    for kind, guess in (("l1", read), ("mean", np.exp(reader.mean))):
        errors = np.abs(guess - truth).mean(0)
        metrics |= {f"{kind}/{name}": float(error) for name, error in zip(reader.names, errors, strict=True)}
    log.info("known measures: %.0f %% of %g %% intervals hold", 100 * metrics["held"], 100 * reader.level)
    return metrics
