"""What a folder has of landmarks, in whatever form: `landmarks.csv`, a file beside every shape, or one file for all.

Only one form is read, which is then told of every shape by the same names.
"""

import os
import re
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from lssd_learn.collections.landmark_files.files import ONE_SPECIMEN, TABLES, read_specimens, suffix_of
from lssd_learn.collections.landmark_files.morphoj import is_morphoj
from lssd_learn.collections.landmark_files.morphologika import is_morphologika
from lssd_learn.collections.landmark_files.specimen import Specimen
from lssd_learn.collections.reading.landmark_table import Landmark, LandmarkTable, is_code, read_landmarks
from lssd_learn.collections.reading.listing import check_file
from lssd_learn.collections.reading.names import Names, composed
from lssd_learn.collections.reading.table import find_table
from lssd_learn.collections.reading.told import Told
from lssd_learn.errors import InputError, reading, some_of
from lssd_learn.shapes.reading.words import text_of

HEAD = 2**16  # bytes that tell what a text is: two lines of a wide table
# What Slicer calls a landmark: the name of the list, which is that of the file or of the specimen, and a number.
_NUMBERED = re.compile(r"(?P<list>.*\S)[-_ ](?P<number>\d+)")


@dataclass(frozen=True)
class LandmarkSource:
    """Where the landmarks of a folder are.

    Attributes:
        files: one for all shapes, or one for each of some.
        shapes: of which shape each file is; empty where one is for all.
        is_table: whether it is a `landmarks.csv` of our own.
    """

    files: tuple[Path, ...]
    shapes: tuple[int, ...] = ()
    is_table: bool = False

    @property
    def path(self) -> Path:
        """For messages: the file, or the files as a pattern."""
        first = self.files[0]
        return first.with_name(f"*{suffix_of(first.name)}") if self.shapes else first


def find_landmarks(folder: Path, names: Names, told: Told) -> LandmarkSource | None:
    """The landmarks of a folder; None without. Files beside no shape are left alone, with a warning.

    Raises:
        InputError: landmarks in two forms, or two files for all.
    """
    with reading(folder):
        files = sorted(name for name in os.listdir(folder) if not name.startswith((".", "~")))
    beside: dict[str, dict[int, Path]] = defaultdict(dict)
    for_all, alone = [], []
    table = find_table(folder, "landmarks")
    if table is not None:
        check_file(table)
        for_all.append(LandmarkSource((table,), is_table=not is_morphoj(_head(table))))
    for path in (folder / file for file in files):
        suffix = suffix_of(path.name)
        stem = composed(path.name[: len(path.name) - len(suffix)])
        if not suffix or path == table or not _is_landmarks(path, suffix, stem):
            continue
        shape = names.find(stem)
        if shape is not None:
            beside[suffix][shape] = path
        elif suffix in ONE_SPECIMEN:
            alone.append(path.name)
        else:
            for_all.append(LandmarkSource((path,)))
    found = for_all + [LandmarkSource(tuple(paths.values()), tuple(paths)) for paths in beside.values()]
    if len(found) > 1:
        first, second = (source.files[0].name for source in found[:2])
        raise InputError(f"{folder}: expected landmarks in one form, got {first} and {second}")
    if alone:
        like = names.names[0] + suffix_of(alone[0])
        told.warn(f"{folder.name}: not read: {some_of(alone)}: landmarks, but not called after a shape, such as {like}")
    return found[0] if found else None


def _is_landmarks(path: Path, suffix: str, stem: str) -> bool:
    """Whether a file has landmarks: by its suffix, or for a text by what is in it, or by its name."""
    if suffix not in TABLES:
        return True
    if suffix != ".txt" or not path.is_file():
        return False
    head = _head(path)
    return is_morphologika(head) or (stem.casefold() == "landmarks" and is_morphoj(head))


def _head(path: Path) -> str:
    """The first lines of a file, "" if it is no text."""
    with reading(path), path.open("rb") as stream:
        data = stream.read(HEAD)
    try:
        return text_of(data[: len(data) // 2 * 2]).removeprefix("\ufeff")
    except (ValueError, UnicodeError):
        return ""


def read_source(source: LandmarkSource, names: Names, told: Told) -> LandmarkTable:
    """The landmarks of n shapes; what was left out or guessed is told.

    Raises:
        InputError: a file that cannot be read, a specimen that is no shape, other landmarks than other specimens have.
    """
    if source.is_table:
        read = read_landmarks(source.files[0], names)
        if read.carried:
            told.warn(
                f"{source.files[0].name}: {read.carried} of its {sum(map(len, read.rows))} landmarks were carried over "
                "from other shapes, as their origin says; they are taken as if somebody had placed them"
            )
        return read
    if source.shapes:
        found = [(i, _only(path), path) for i, path in zip(source.shapes, source.files, strict=True)]
    else:
        path = source.files[0]
        found = [(names.position(one.name, str(path)), one, path) for one in read_specimens(path)]
    for _, one, path in found:
        if one.notes:
            told.warn(f"{path.name}: {', '.join(one.notes)}")
    labels = _common([one.labels for _, one, _ in found], [one.name for _, one, _ in found])
    absent = _absent(labels, [path if source.shapes else f"{path}: {one.name}" for _, one, path in found], told)
    rows: list[list[Landmark]] = [[] for _ in range(len(names))]
    missing: list[list[str]] = [[] for _ in range(len(names))]
    spaces = [""] * len(names)
    for (i, one, path), known, lacking in zip(found, labels, absent, strict=True):
        if rows[i] or missing[i]:
            raise InputError(f"{path}: expected each specimen once, got {names.names[i]!r} again")
        spaces[i] = one.space
        missing[i] += lacking
        for label, point in zip(known, one.points.tolist(), strict=True):
            if np.isnan(point).any():
                missing[i].append(label)
            else:
                rows[i].append(Landmark(label, None, tuple(point), str(path), is_code(point)))
    return LandmarkTable(rows, missing, tuple(spaces))


def _only(path: Path) -> Specimen:
    specimens = read_specimens(path)
    if len(specimens) != 1:
        raise InputError(
            f"{path}: expected the landmarks of the shape of this name alone, got {len(specimens):,} specimens"
        )
    return specimens[0]


def _common(labels: Sequence[tuple[str, ...]], names: Sequence[str]) -> list[tuple[str, ...]]:
    """The labels of each specimen, without the name of the list that Slicer puts before the number of each."""
    if len(set(labels)) == 1:
        return list(labels)
    matches = [[_NUMBERED.fullmatch(label) for label in own] for own in labels]
    if not all(own and all(own) for own in matches):
        return list(labels)
    lists = [{match["list"] for match in own if match} for own in matches]
    if any(len(own) > 1 for own in lists) or len(set.union(*lists)) == 1:
        return list(labels)
    return [tuple(match["number"] for match in own if match) for own in matches]


def _absent(labels: Sequence[tuple[str, ...]], wheres: Sequence[object], told: Told) -> list[list[str]]:
    """The landmarks of the specimen with most of them that each of the others has not, with a warning.

    Raises:
        InputError: a specimen has one that this has not, or fewer, where landmarks are told by their order alone.
    """
    most = max(range(len(labels)), key=lambda i: len(labels[i]), default=0)
    absent = []
    for own, where in zip(labels, wheres, strict=True):
        odd = [label for label in own if label not in labels[most]]
        lacking = [label for label in labels[most] if label not in own]
        by_order = all(label.isdigit() for label in labels[most])
        if odd or (lacking and by_order):
            got = f"got {len(own):,}" + (f", of them {odd[0]!r}" if odd else "")
            raise InputError(f"{where}: expected the {len(labels[most]):,} landmarks of {wheres[most]}, {got}")
        if lacking:
            told.warn(f"{where}: no landmark {some_of(lacking)}, which others have: taken as missing")
        absent.append(lacking)
    return absent
