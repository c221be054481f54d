"""`.pts` of Landmark editor (IDAV): a name and a point a line, in the coordinates of the mesh; 9999 is missing.

Reference:
    Wiley et al., "Evolutionary morphing", IEEE Visualization (2005); Morpho's `read.pts` for what is missing.
"""

from collections.abc import Sequence

from lssd_learn.collections.landmark_files.specimen import Specimen, place, specimen, words_of
from lssd_learn.shapes.reading.words import Numbers, whole

MISSING = 9999.0


def read(text: str) -> list[Specimen]:
    """The points of a file.

    Raises:
        ValueError: other than a version, a number of points and so many lines `name x y z`.
    """
    lines = [(number, line.rsplit(maxsplit=3)) for number, line in enumerate(text.split("\n"), 1) if line.strip()]
    if not lines or lines[0][1][0].casefold() != "version":
        raise ValueError("expected Version 1.0 in its first line")
    if len(lines) < 2 or len(lines[1][1]) != 1:
        raise ValueError("expected the number of points in its second line")
    count, lines = whole(lines[1][1][0]), lines[2:]
    if count != len(lines):
        raise ValueError(f"it announces {count:,} points, {len(lines):,} are there")
    labels, points, numbers = [], [], Numbers()
    for number, words in lines:
        try:
            points.append(place(words[-3:], numbers, MISSING))
            if len(words) < 4:
                raise ValueError(f"expected a name and x, y, z, got {' '.join(words)[:60]!r}")
        except ValueError as error:
            raise ValueError(f"line {number}: {error}") from None
        labels.append(words[0].strip())  # which may hold spaces
    return [specimen("", labels, points, notes=numbers.notes)]


def write(specimens: Sequence[Specimen]) -> str:
    """The file of one specimen."""
    (one,) = specimens
    lines = ["Version 1.0", str(len(one.labels))]
    for label, point in zip(one.labels, one.points, strict=True):
        lines.append(" ".join([label, *words_of(point, f"{MISSING:f}")]))
    return "\n".join(lines) + "\n"
