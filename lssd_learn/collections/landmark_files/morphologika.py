"""Morphologika text: sections in brackets, several specimens a file, landmarks by their order.

Reference:
    O'Higgins & Jones, Tools for statistical shape analysis, Hull York Medical School (2006).
"""

import math
import re
from collections.abc import Sequence

from lssd_learn.collections.landmark_files.specimen import Specimen, numbered, place, specimen, words_of
from lssd_learn.shapes.reading.words import Numbers, whole

MISSING = 9999.0  # of Landmark editor, whose points are often kept in this form
_SECTION = re.compile(r"\[\s*(\w+)\s*\]?$")
# What says nothing of the landmarks.
BESIDE = {"labels", "labelvalues", "groups", "wireframe", "polygons", "polygon", "images", "pixelspermm"}


def is_morphologika(text: str) -> bool:
    """Whether a text begins with a section of this format."""
    first = next((line.strip().casefold() for line in text.split("\n") if line.strip()), "")
    match = _SECTION.match(first)
    return match is not None and match[1] in {"individuals", "landmarks", "dimensions", "names", *BESIDE}


def read(text: str) -> list[Specimen]:
    """The specimens of a file, named by its section of names or by the lines `'name` between their points.

    Labels, groups and wireframes are left out.

    Raises:
        ValueError: an unknown section, one that is missing, landmarks in two dimensions, other numbers of names or
            points than announced.
    """
    sections, lines_of, quoted = _sections(text)
    n, L, dimensions = (_count(sections, name) for name in ("individuals", "landmarks", "dimensions"))
    if dimensions != 3:
        raise ValueError(f"expected landmarks in three dimensions, got {dimensions}")
    rows = sections.get("rawpoints", [])
    if len(rows) != n * L:
        raise ValueError(f"it announces {n:,} times {L:,} landmarks, {len(rows):,} lines of points are there")
    names = sections.get("names", quoted if len(quoted) == n else [])
    if not names and n == 1:
        names = [""]
    if len(names) != n:
        raise ValueError(f"expected the names of {n:,} individuals, got {len(names):,}")
    numbers, points = Numbers(), []
    for number, row in zip(lines_of, rows, strict=True):
        try:
            points.append(place(re.split(r"[\s;]+|,\s+", row), numbers))
        except ValueError as error:
            raise ValueError(f"line {number}: {error}") from None
    far, notes = [set(point) == {MISSING} for point in points], numbers.notes
    if any(far):
        points = [[math.nan] * 3 if is_far else point for point, is_far in zip(points, far, strict=True)]
        notes = (*notes, f"{MISSING:g} three times taken for missing")
    return [specimen(name, numbered(L), points[i * L : (i + 1) * L], notes=notes) for i, name in enumerate(names)]


def _sections(text: str) -> tuple[dict[str, list[str]], list[int], list[str]]:
    """The lines of each section, the numbers of those with points, and the comments `'name` between them."""
    sections: dict[str, list[str]] = {}
    here, numbers, quoted = "", [], []
    for number, line in enumerate(text.split("\n"), 1):
        line = line.strip()
        match = _SECTION.match(line.casefold())
        if match:
            here = match[1]
            if here in sections:
                raise ValueError(f"line {number}: expected each section once, got [{here}] again")
            if here not in BESIDE | {"individuals", "landmarks", "dimensions", "names", "rawpoints"}:
                raise ValueError(f"line {number}: expected a section of Morphologika, got {line[:30]!r}")
            sections[here] = []
        elif line.startswith("'"):
            quoted += [line[1:].lstrip("#").strip()] if here == "rawpoints" else []
        elif line and not here:
            raise ValueError(f"line {number}: expected a section such as [individuals], got {line[:30]!r}")
        elif line:
            sections[here].append(line)
            numbers += [number] if here == "rawpoints" else []
    return sections, numbers, quoted


def _count(sections: dict[str, list[str]], name: str) -> int:
    lines = sections.get(name, [])
    if len(lines) != 1:
        raise ValueError(f"expected one number in section [{name}], got {len(lines)} lines")
    return whole(lines[0])


def write(specimens: Sequence[Specimen]) -> str:
    """The file of many specimens with the same number of landmarks; a missing one is NaN.

    Raises:
        ValueError: other numbers of landmarks.
    """
    numbers = {len(one.labels) for one in specimens}
    if len(numbers) != 1:
        raise ValueError(f"expected the same number of landmarks of all specimens, got {sorted(numbers)}")
    lines = ["[individuals]", str(len(specimens)), "[landmarks]", str(numbers.pop()), "[dimensions]", "3", "[names]"]
    lines += [one.name for one in specimens] + ["[rawpoints]"]
    for one in specimens:
        lines += ["", f"'{one.name}", "", *(" ".join(words_of(point, "NaN")) for point in one.points)]
    return "\n".join(lines) + "\n"
