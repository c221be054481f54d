"""What was read of several scans: as rows, on a screen, as JSON; a scan that cannot be read is a line that says why."""

import json
import logging
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from lssd_learn.collections import Collection
from lssd_learn.collections.anthropometry.measures import MEASURES
from lssd_learn.errors import InputError
from lssd_learn.models.measuring.reader import BodyReader, Reading
from lssd_learn.progress import track
from lssd_learn.written import write_rows

log = logging.getLogger(__name__)

CAUTION = "intervals are those of generated people; how far real ones differ from the body model nobody has measured"


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
    """A row a scan: `name`, `unit`, `up`, each measure with the ends of its interval, and what is seen of faults, see
    `Reading`: `off_mm`, `missing`, `extra`, `unlike`, and `signs`."""
    rows = []
    for name, reading in found.items():
        row: dict[str, object] = {"name": name, "unit": reading.unit, "up": towards(reading)}
        for place, measure in enumerate(reader.names):
            row[measure] = float(reading.values[place])
            row[f"{measure}_low"], row[f"{measure}_high"] = float(reading.low[place]), float(reading.high[place])
        seen = {"off_mm": reading.off, "missing": reading.missing, "extra": reading.extra}
        seen["unlike"] = reading.unlike
        rows.append(row | seen | {"signs": "; ".join(reading.signs)})
    return rows


def write_table(reader: BodyReader, found: Mapping[str, Reading], path: Path) -> None:
    """`as_rows` as CSV or, where the name of the file ends in .json, as JSON."""
    rows = as_rows(reader, found)
    if path.suffix == ".json":
        path.write_text(json.dumps({"level": reader.level, "scans": rows}, indent=1) + "\n", encoding="utf-8")
    else:
        write_rows(rows, path)


def told(reader: BodyReader, found: Mapping[str, Reading]) -> list[str]:
    """Lines of a table for a screen, see `lines_of`, and a last one of caution."""
    lines = [line for name, reading in found.items() for line in lines_of(reader, name, reading)]
    return [*lines, CAUTION] if lines else []


def lines_of(reader: BodyReader, name: str, reading: Reading) -> list[str]:
    """The name of a scan and a line a measure: lengths in centimetres, each with its interval."""
    lines = [f"{name} (in {reading.unit}, up is {towards(reading)}; {100 * reader.level:g} % intervals)"]
    for title, value, low, high in numbers_of(reader, reading):
        number, _, unit = value.partition(" ")
        lines.append(f"  {title:<18}{number:>8} {unit:<3} {low:>8} to {high}")
    return lines + [f"  look at it: {sign}" for sign in reading.signs]


def numbers_of(reader: BodyReader, reading: Reading) -> Iterator[tuple[str, str, str, str]]:
    """Of each measure its title, the number with its unit, lengths in centimetres, and the ends of its interval."""
    known = {measure.name: measure for measure in MEASURES}
    for place, column in enumerate(reader.names):
        measure = known[column]
        unit, per = ("cm", 10.0) if measure.unit == "mm" else (measure.unit, 1.0)
        digits = 2 if unit == "m²" else 1
        value, low, high = (f"{some[place] / per:.{digits}f}" for some in (reading.values, reading.low, reading.high))
        yield measure.title, f"{value} {unit}", low, high


def towards(reading: Reading) -> str:
    """The axis of the file that is nearest to up, by the hips: "+y", and how far it is off from 5° on."""
    up = reading.upright[:, 2]
    axis = int(np.abs(up).argmax())
    off = float(np.degrees(np.arccos(min(1.0, abs(up[axis])))))
    return f"{'-' if up[axis] < 0 else '+'}{'xyz'[axis]}" + (f" ({off:.0f}° off)" if off >= 5 else "")
