"""The tables beside a folder of shapes: `labels.csv` and `landmarks.csv`, read and checked for `folder.py`.

Names in them are only ever compared with those of the shapes, never opened as paths.
"""

import csv
import logging
import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from lssd_learn.errors import InputError, reading

log = logging.getLogger(__name__)

# How people write that they do not know a number.
MISSING = {"na", "n/a", "nan", "none", "null", "unknown", "inf", "-inf", "?", "-"}


@dataclass(frozen=True)
class Labels:
    """What `labels.csv` says of n shapes.

    Attributes:
        parameters: (n, p) float64, or None without a numeric column.
        parameter_names: p of them.
        groups: name → (n,) labels as written.
    """

    parameters: np.ndarray | None
    parameter_names: list[str]
    groups: dict[str, np.ndarray]


@dataclass(frozen=True)
class Landmark:
    """A row of `landmarks.csv`: the vertex, in the numbering of the file of the shape, or else the point."""

    name: str
    vertex: int | None
    point: tuple[float, float, float] | None
    where: str  # file and line, for messages


def read_labels(path: Path, names: Sequence[str], groups: Collection[str] = ()) -> Labels:
    """Read `labels.csv`: a column of numbers is a parameter, any other a group.

    Args:
        path: the file; its first column is called `name`.
        names: of the shapes; each must have exactly one row.
        groups: columns that are groups even if they hold numbers.

    Raises:
        InputError: a name without a row, with two, or unknown; an empty cell; a number that is missing (such as
            "n/a") among others; an unknown column in `groups`.
    """
    header, rows = _read(path, required=("name",))
    columns = [column for column in header if column != "name"]
    for column in groups:
        if column not in columns:
            raise InputError(f"{path}: expected a column {column!r} to group by, got {', '.join(columns) or 'none'}")
    by_name: dict[str, dict[str, str]] = {}
    for where, row in rows:
        _check_name(where, row["name"], names)
        if row["name"] in by_name:
            raise InputError(f"{where}: expected one row a shape, got a second one for {row['name']!r}")
        for column in columns:
            if not row[column]:
                raise InputError(f"{where}: expected a value in column {column!r}, got an empty cell")
        by_name[row["name"]] = row
    absent = [name for name in names if name not in by_name]
    if absent:
        raise InputError(f"{path}: expected a row for every shape, got none for {absent[0]!r}{_and_more(absent)}")

    parameters, grouped = {}, {}
    for column in columns:
        texts = [by_name[name][column] for name in names]
        numbers = [_number(text) for text in texts]
        words = [i for i, number in enumerate(numbers) if number is None]
        unknown = [i for i in words if texts[i].lower() in MISSING]
        if column not in groups and unknown and len(words) < len(names):
            i = unknown[0]
            raise InputError(
                f"{path}: expected a number in column {column!r} for {names[i]!r}, as there are others (or the column "
                f"among collection.groups), got {texts[i]!r}"
            )
        if column in groups or words:
            grouped[column] = np.array(texts)
            if column not in groups and len(words) < len(names):
                log.info("%s: column %r is not all numbers (%r), so it is a group", path, column, texts[words[0]])
        else:
            parameters[column] = numbers
    array = np.array(list(parameters.values()), dtype=float).T if parameters else None
    return Labels(array, list(parameters), grouped)


def read_landmarks(path: Path, names: Sequence[str]) -> list[list[Landmark]]:
    """Read `landmarks.csv`: columns `name`, `landmark` and `vertex` or `x`, `y`, `z` or both; the vertex then wins.

    Args:
        path: the file.
        names: of the shapes; some may be without landmarks.

    Returns:
        The landmarks of each shape, in the order of the file.

    Raises:
        InputError: an unknown shape, a landmark given twice, a row without a place, a place that is no number.
    """
    header, rows = _read(path, required=("name", "landmark"), allowed=("vertex", "x", "y", "z"))
    if "vertex" not in header and not {"x", "y", "z"} <= set(header):
        raise InputError(f"{path}: expected a column vertex or columns x, y, z, got {', '.join(header)}")
    landmarks: dict[str, dict[str, Landmark]] = {name: {} for name in names}
    for where, row in rows:
        _check_name(where, row["name"], names)
        if not row["landmark"]:
            raise InputError(f"{where}: expected the landmark's name, got an empty cell")
        if row["landmark"] in landmarks[row["name"]]:
            raise InputError(f"{where}: expected each landmark once, got {row['landmark']!r} of {row['name']!r} again")
        vertex, point = row.get("vertex", ""), tuple(_number(row.get(axis, "")) for axis in "xyz")
        if vertex and not (vertex.isascii() and vertex.isdigit()):
            raise InputError(f"{where}: expected a vertex, 0 or more, got {vertex!r}")
        if not vertex and None in point:
            raise InputError(f"{where}: expected a vertex or a point x, y, z in numbers, got neither")
        place = (int(vertex), None) if vertex else (None, point)
        landmarks[row["name"]][row["landmark"]] = Landmark(row["landmark"], *place, where)
    return [list(landmarks[name].values()) for name in names]


def _read(
    path: Path, required: Sequence[str], allowed: Sequence[str] | None = None
) -> tuple[list[str], list[tuple[str, dict[str, str]]]]:
    """Header and rows of a table, cells stripped; each row with its file and line."""
    try:
        with reading(path), path.open(newline="", encoding="utf-8-sig") as file:
            reader = csv.reader(file, strict=True)
            lines = [(reader.line_num, [cell.strip() for cell in line]) for line in reader]
    except (UnicodeDecodeError, csv.Error) as error:
        raise InputError(f"{path}: expected comma-separated text in UTF-8: {error}") from error
    lines = [(number, cells) for number, cells in lines if any(cells)]
    header = lines[0][1] if lines else []
    if len(header) == 1 and any(mark in header[0] for mark in ";\t"):
        raise InputError(f"{path}: expected commas between the columns, got {header[0]!r}")
    for column in required:
        if column not in header:
            raise InputError(f"{path}: expected a column {column!r}, got {', '.join(header) or 'an empty file'}")
    for column in header:
        if header.count(column) > 1 or not column:
            raise InputError(f"{path}: expected each column to have a name of its own, got {column!r}")
        if allowed is not None and column not in (*required, *allowed):
            raise InputError(f"{path}: expected columns {', '.join((*required, *allowed))}, got {column!r}")
    rows = []
    for number, cells in lines[1:]:
        where = f"{path}, line {number}"
        if len(cells) != len(header):
            raise InputError(f"{where}: expected {len(header)} columns, got {len(cells)}")
        rows.append((where, dict(zip(header, cells, strict=True))))
    return header, rows


def _check_name(where: str, name: str, names: Sequence[str]) -> None:
    if name not in names:
        some = ", ".join(names[:3]) + (", …" if len(names) > 3 else "")
        raise InputError(f"{where}: expected the name of a shape ({some}), got {name!r}")


def _number(text: str) -> float | None:
    try:
        number = float(text)
    except ValueError:
        return None
    # float() also takes 1_000 and nan, which nobody means as a number here.
    return number if math.isfinite(number) and "_" not in text else None


def _and_more(items: Sequence[str]) -> str:
    return f" and {len(items) - 1} more" if len(items) > 1 else ""
