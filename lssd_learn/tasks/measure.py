"""`task=measure`: centimetres of the people in a folder of scans, by the reader that `task=reader` has made."""

import logging
from pathlib import Path

from lssd_learn.errors import InputError
from lssd_learn.models.measuring import BodyReader
from lssd_learn.models.measuring.table import read_all, told, write_table
from lssd_learn.pieces import Pieces

log = logging.getLogger(__name__)


def run(pieces: Pieces, out: Path, reader: str | None, unit: str = "auto") -> dict[str, float]:
    """Write measures.csv and measures.json: each measure of each scan with an interval, in millimetres.

    Args:
        reader: the file that `task=reader` has written.
        unit: of the scans: m, cm, mm, or auto, which finds out, scan by scan.

    Returns:
        "shapes", how many were read, and "refused", how many were not, which the log says of each.

    Raises:
        InputError: no reader, no scan that can be read.
    """
    if reader is None:
        raise InputError("task.reader: expected a reader of body measures, reader.npz of experiment=measures")
    known = BodyReader.load(Path(reader).expanduser())
    found, refused = read_all(known, pieces.pipeline.collection, unit)
    for line in refused:
        log.warning("%s", line)
    if not found:
        raise InputError(f"none of {len(refused)} scans can be read; the first: {refused[0]}")
    for line in told(known, found):
        log.info("%s", line)
    for name in ("measures.csv", "measures.json"):
        write_table(known, found, out / name)
    return {"shapes": len(found), "refused": len(refused)}
