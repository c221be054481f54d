"""What was read of several scans: as rows, on a screen, as JSON; a scan that cannot be read is a line that says why."""

import json
import logging
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

from lssd_learn.collections import Collection
from lssd_learn.collections.anthropometry.measures import MEASURES
from lssd_learn.errors import InputError
from lssd_learn.models.measuring.reader import BodyReader, Reading
from lssd_learn.progress import track
from lssd_learn.rows import write_rows

log = logging.getLogger(__name__)


def read_all(reader: BodyReader, scans: Collection, unit: str = "auto") -> tuple[dict[str, Reading], list[str]]:
    """Name → what was read of each scan, and why each of the others was not: a line each."""
    found, refused = {}, []
    with _hushed():
        for i, name in enumerate(track(list(scans.names), "measuring")):
            try:
                found[name] = reader.read(scans[i], unit, name)
            except InputError as error:
                refused.append(str(error))
    if unit == "auto":
        for name, reading in found.items():
            log.info("%s: taken to be in %s", name, reading.unit)
    return found, refused


@contextmanager
def _hushed() -> Iterator[None]:
    """What rooms of their own account say of doubtful maps and sizes is told once, by the reader."""
    rooms = [logging.getLogger(f"lssd_learn.{room}") for room in ("maps", "latent", "trusting")]
    levels = [room.level for room in rooms]
    try:
        for room in rooms:
            room.setLevel(logging.ERROR)
        yield
    finally:
        for room, level in zip(rooms, levels, strict=True):
            room.setLevel(level)


def as_rows(reader: BodyReader, found: Mapping[str, Reading]) -> list[dict[str, object]]:
    """A row a scan: `name`, `unit`, each measure with the ends of its interval, `unlike` and `map_quality`."""
    rows = []
    for name, reading in found.items():
        row: dict[str, object] = {"name": name, "unit": reading.unit}
        for place, measure in enumerate(reader.names):
            row[measure] = float(reading.values[place])
            row[f"{measure}_low"], row[f"{measure}_high"] = float(reading.low[place]), float(reading.high[place])
        rows.append(row | {"unlike": reading.unlike, "map_quality": reading.quality})
    return rows


def write_table(reader: BodyReader, found: Mapping[str, Reading], path: Path) -> None:
    """`as_rows` as CSV or, where the name of the file ends in .json, as JSON."""
    rows = as_rows(reader, found)
    if path.suffix == ".json":
        path.write_text(json.dumps({"level": reader.level, "scans": rows}, indent=1) + "\n", encoding="utf-8")
    else:
        write_rows(rows, path)


def told(reader: BodyReader, found: Mapping[str, Reading]) -> list[str]:
    """Lines of a table for a screen, see `lines_of`."""
    return [line for name, reading in found.items() for line in lines_of(reader, name, reading)]


def lines_of(reader: BodyReader, name: str, reading: Reading) -> list[str]:
    """The name of a scan and a line a measure: lengths in centimetres, each with its interval."""
    known = {measure.name: measure for measure in MEASURES}
    lines = [f"{name} (in {reading.unit}; {100 * reader.level:g} % intervals)"]
    for place, column in enumerate(reader.names):
        measure = known.get(column)
        unit, per = ("", 1.0) if measure is None else ("cm", 10.0) if measure.unit == "mm" else (measure.unit, 1.0)
        value, low, high = (some[place] / per for some in (reading.values, reading.low, reading.high))
        digits = 2 if unit == "m²" else 1
        numbers = f"{value:8.{digits}f} {unit:<3} {low:8.{digits}f} to {high:.{digits}f}"
        lines.append(f"  {column if measure is None else measure.title:<18}{numbers}")
    return lines
