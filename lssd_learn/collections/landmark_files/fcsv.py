"""`.fcsv`, the points of 3D Slicer before it had `.mrk.json`: comma-separated, in RAS or LPS.

Reference:
    Slicer, Modules/Loadable/Markups/MRML/vtkMRMLMarkupsFiducialStorageNode.cxx.
"""

import csv
import io
from collections.abc import Sequence

import numpy as np

from lssd_learn.collections.landmark_files.specimen import SPACES, Specimen, place, specimen, words_of
from lssd_learn.shapes.reading.words import Numbers

COLUMNS = ["id", *"xyz", "ow", "ox", "oy", "oz", "vis", "sel", "lock", "label", "desc", "associatedNodeID"]
STATUS = len(COLUMNS)  # newer ones write, behind the columns they name, whether a position is defined
DEFINED = "2"


def read(text: str) -> list[Specimen]:
    """The points of a file; selected or not, locked or not, visible or not.

    Without a line on the coordinate system it is RAS, as Slicer has it then.

    Raises:
        ValueError: a line that is no point, another coordinate system.
    """
    space, notes, columns, labels, points, numbers = "", [], COLUMNS, [], [], Numbers()
    for number, line in enumerate(text.split("\n"), 1):
        if line.startswith("#"):
            key, _, value = line[1:].partition("=")
            if key.strip().casefold() == "coordinatesystem":
                if value.strip().casefold() not in SPACES:
                    raise ValueError(f"expected CoordinateSystem RAS (0) or LPS (1), got {value.strip()[:30]!r}")
                space = SPACES[value.strip().casefold()]
            elif key.strip().casefold() == "columns":
                columns = [column.strip() for column in value.split(",")]
                if not {"x", "y", "z", "label"} <= set(columns):
                    raise ValueError(f"expected columns x, y, z, label, got {value.strip()[:80]!r}")
            continue
        if not line.strip():
            continue
        try:
            cells = [cell.strip() for cell in next(csv.reader([line]))]
            if len(cells) < max(columns.index(column) for column in ("x", "y", "z", "label")) + 1:
                raise ValueError(f"expected {len(columns)} columns, got {len(cells)}")
            point = place([cells[columns.index(axis)] for axis in "xyz"], numbers)
        except (ValueError, csv.Error) as error:
            raise ValueError(f"line {number}: {error}") from None
        if numbers.commas:
            raise ValueError(f"line {number}: expected decimal points, got commas")
        if columns == COLUMNS and len(cells) > STATUS and cells[STATUS] not in ("", DEFINED):
            point = [np.nan] * 3
        labels.append(cells[columns.index("label")] or str(len(labels) + 1))
        points.append(point)
    if not space:
        space, notes = "RAS", ["it does not say its coordinate system: RAS, as Slicer has it then"]
    return [specimen("", labels, points, space, notes)]


def write(specimens: Sequence[Specimen]) -> str:
    """The file of one specimen, in its coordinate system; LPS, which Slicer writes, where it says none."""
    (one,) = specimens
    stream = io.StringIO()
    stream.write("# Markups fiducial file version = 5.2\n")
    stream.write(f"# CoordinateSystem = {one.space or 'LPS'}\n# columns = {','.join(COLUMNS)}\n")
    rows = csv.writer(stream, lineterminator="\n")
    for i, (label, point) in enumerate(zip(one.labels, one.points, strict=True)):
        status = "0" if np.isnan(point).any() else DEFINED
        rows.writerow([i + 1, *words_of(point, "nan"), 0, 0, 0, 1, 1, 1, 0, label, "", "", status, 0])
    return stream.getvalue()
