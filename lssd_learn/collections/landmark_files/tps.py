"""`.tps` of Rohlf's programs (tpsDig, tpsRelw): several specimens a file, landmarks by their order.

Reference:
    Rohlf, "The tps series of software", Hystrix 26 (2015); geomorph's `readland.tps` for scale and names.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

from lssd_learn.collections.landmark_files.specimen import Specimen, numbered, place, specimen, words_of
from lssd_learn.shapes.reading.parsed import some
from lssd_learn.shapes.reading.words import Numbers, whole

MISSING = -1.0  # three times, or NA
_KEY = re.compile(r"\s*([A-Za-z][A-Za-z0-9_]*)\s*=(.*)")
# What has lines of points of its own behind it, which are no landmarks.
_COUNTED = {"POINTS", "POINTS3", "RADII"}


@dataclass
class _Open:
    """A specimen whose lines are still being read."""

    count: int
    points: list[list[float]] = field(default_factory=list)
    keys: dict[str, str] = field(default_factory=dict)
    others: int = 0  # lines of a curve that are still due


def read(text: str) -> list[Specimen]:
    """The specimens of a file: named by ID, where it is no mere number, or IMAGE; in units of SCALE, where given.

    Curves and outlines are left out, which is noted.

    Raises:
        ValueError: landmarks in two dimensions, more or fewer than announced, a scale of some specimens only.
    """
    found: list[_Open] = []
    numbers, curves = Numbers(), 0
    for number, line in enumerate(text.split("\n"), 1):
        match = _KEY.match(line)
        if not match and not line.strip():
            continue
        key = match[1].upper() if match else ""
        try:
            if key in ("LM", "LM3"):
                _close(found)
                found.append(_Open(whole(match[2].strip()) if match else 0))
            elif not found:
                raise ValueError(f"expected LM3= before anything else, got {line.strip()[:60]!r}")
            elif key:
                found[-1].keys[key] = match[2].strip() if match else ""
                if key in _COUNTED:
                    found[-1].others, curves = whole(found[-1].keys[key]), curves + 1
            elif found[-1].others:
                found[-1].others -= 1
            else:
                found[-1].points.append(_point(line.split(), numbers))
        except ValueError as error:
            raise ValueError(f"line {number}: {error}") from None
    _close(found)
    if not found:
        raise ValueError("expected LM3= and landmarks, found none")
    scaled = [one for one in found if "SCALE" in one.keys]
    if scaled and len(scaled) < len(found):
        raise ValueError(f"expected SCALE= of all {len(found):,} specimens or of none, got it of {len(scaled):,}")
    notes = [*numbers.notes, *([f"left out {some(curves, 'curve')}"] if curves else [])]
    return [_specimen(one, notes) for one in found]


def _point(words: list[str], numbers: Numbers) -> list[float]:
    if len(words) == 2:
        raise ValueError(f"expected landmarks in three dimensions, got {' '.join(words)!r}")
    return place(words, numbers, MISSING)


def _close(found: list[_Open]) -> None:
    if found and (len(found[-1].points) != found[-1].count or found[-1].others):
        there = f"{len(found[-1].points):,} are there"
        raise ValueError(f"specimen {len(found)} announces {found[-1].count:,} landmarks, {there}")


def _specimen(one: _Open, notes: list[str]) -> Specimen:
    identity = one.keys.get("ID", "")
    image = re.sub(r"\.\w+$", "", re.split(r"[\\/]", one.keys.get("IMAGE", ""))[-1])
    name = image if image and (not identity or identity.isdigit()) else identity
    made = specimen(name, numbered(one.count), one.points, notes=notes)
    if "SCALE" not in one.keys:
        return made
    (scale,) = Numbers().floats([one.keys["SCALE"]])
    if not 0 < scale < float("inf"):
        raise ValueError(f"expected SCALE= above 0, got {one.keys['SCALE'][:30]!r}")
    return replace(made, points=made.points * scale)


def write(specimens: Sequence[Specimen]) -> str:
    """The file of many specimens."""
    lines = []
    for one in specimens:
        lines.append(f"LM3={len(one.labels)}")
        lines.extend(" ".join(words_of(point, "NA")) for point in one.points)
        lines.append(f"ID={one.name}")
    return "\n".join(lines) + "\n"
