"""The files of a folder of shapes: which are shapes, which are maps and between what. Used by `folder.py`.

A name found in a file name is only ever looked up among the shapes, so nothing outside the folder is opened.
"""

import os
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from lssd_learn.collections.reading.names import composed
from lssd_learn.errors import InputError, reading
from lssd_learn.shapes.files import FORMATS

TABLES = (".csv", ".tsv", ".txt", ".xls", ".xlsx", ".ods")

# What stands beside shapes and says nothing of them: tables, texts, pictures, settings, materials, archives.
BESIDE = frozenset(
    [
        *TABLES,
        *("", ".md", ".rst", ".pdf", ".doc", ".docx", ".rtf", ".odt", ".html", ".htm", ".log", ".bib", ".url", ".lnk"),
        *(".png", ".jpg", ".jpeg", ".gif", ".bmp", ".tif", ".tiff", ".svg", ".webp", ".tga", ".dds", ".mp4", ".mtl"),
        *(".json", ".yaml", ".yml", ".toml", ".xml", ".ini", ".cfg", ".db", ".py", ".r", ".m", ".ipynb", ".sh", ".bat"),
        *(".fcsv", ".pts", ".tps"),  # landmarks, see `landmark_sources.py`
        *(".zip", ".tar", ".tgz", ".7z", ".rar", ".md5", ".sha256", ".bak", ".tmp", ".swp", ".lock"),
    ]
)


def shape_files(folder: Path) -> list[Path]:
    """The mesh and cloud files of a folder, sorted by name; hidden ones are left out.

    Raises:
        InputError: no such folder, no shape in it, two of one name.
    """
    if not folder.is_dir():
        raise InputError(f"{folder}: expected a folder of shapes, it is {'a file' if folder.exists() else 'not there'}")
    with reading(folder):
        entries = [e for e in os.scandir(folder) if _suffix(e.name) in FORMATS and not e.name.startswith(".")]
        entries.sort(key=lambda entry: entry.name)
        files = [(folder / entry.name, entry.is_file()) for entry in entries]
    if not files:
        others = unread_shapes(folder)
        raise InputError(f"{folder}: expected shapes ({' '.join(FORMATS)}), found {others or 'none'}")
    by_name: dict[str, Path] = {}
    for file, is_file in files:
        if not is_file:
            check_file(file)
        name = composed(file.stem)
        if name in by_name:
            raise InputError(f"{folder}: expected one file a name, got {by_name[name].name} and {file.name}")
        by_name[name] = file
    return [file for file, _ in files]


def unread_shapes(folder: Path) -> str:
    """How many files of which suffixes are not read though they may be meant to be, such as "12 .vtk"; "" for none."""
    with reading(folder):
        names = [e.name for e in os.scandir(folder) if not e.name.startswith((".", "~")) and e.is_file()]
    counts = Counter(_suffix(name) for name in names)
    return ", ".join(f"{n:,} {s}" for s, n in sorted(counts.items()) if s not in BESIDE and s not in FORMATS)


def _suffix(name: str) -> str:
    return os.path.splitext(name)[1].lower()


def check_file(file: Path) -> None:
    """Refuse a folder, and a link that leads nowhere, where a file is meant.

    Raises:
        InputError: says which of the two it is.
    """
    with reading(file):
        if not file.is_file():
            raise InputError(f"{file}: expected a file, it is {'a folder' if file.is_dir() else 'a link to nothing'}")


def map_files(parent: Path, names: Sequence[str]) -> dict[tuple[int, int], Path]:
    """The files in the folder `maps` of a folder, if it exists, by the shapes (a, b) that their names A__B say.

    Args:
        parent: the folder of the shapes; its folder `maps` may be written in capitals.
        names: of the shapes, composed.

    Raises:
        InputError: a file name that says no pair of `names`, or more than one, two files of one pair, two folders, a
            file in place of the folder.
    """
    with reading(parent):
        folders = sorted(parent / name for name in os.listdir(parent) if name.casefold() == "maps")
    if not folders:
        return {}
    folder = folders[0]
    if len(folders) > 1:
        raise InputError(f"{parent}: expected one folder of maps, got {folder.name} and {folders[1].name}")
    if not folder.is_dir():
        raise InputError(f"{folder}: expected a folder of maps A__B.txt, it is a file")
    position = {name: i for i, name in enumerate(names)}
    found: dict[tuple[int, int], Path] = {}
    with reading(folder):
        files = sorted(file for file in folder.iterdir() if not file.name.startswith("."))
    for file in files:
        is_text, stem = file.suffix.lower() == ".txt", composed(file.stem)
        if not is_text and "__" not in stem:
            continue  # a note, perhaps
        words = stem.split("__")  # the names may hold "__" themselves
        splits = [("__".join(words[:n]), "__".join(words[n:])) for n in range(1, len(words))]
        pairs = [(position[a], position[b]) for a, b in splits if a in position and b in position]
        if len(pairs) != 1 or not is_text:
            raise InputError(f"{file}: expected a name A__B.txt of two shapes of the folder, got {file.name}")
        check_file(file)
        if pairs[0] in found:
            raise InputError(f"{folder}: expected one map a pair, got {found[pairs[0]].name} and {file.name}")
        found[pairs[0]] = file
    return found


def beside(parent: Path, folder: str, names: Sequence[str]) -> list[Path]:
    """A text file NAME.txt a shape, in a folder beside the shapes.

    Raises:
        InputError: one that is not there, or is no file.
    """
    files = [parent / folder / f"{name}.txt" for name in names]
    for file in files:
        if not file.exists():
            raise InputError(f"{file}: expected a list of vertices for each shape, this one is not there")
        check_file(file)
    return files


def unread_tables(folder: Path, read: Sequence[Path], has_landmarks: bool) -> list[str]:
    """A line on files that look like tables of labels or landmarks and are not read."""
    with reading(folder):
        names = [name for name in os.listdir(folder) if _suffix(name) in TABLES and not name.startswith((".", "~"))]
    has_labels = any(file.name.casefold().startswith("labels") for file in read)
    kinds = {"labels": has_labels, "landmarks": has_landmarks}
    read_names = {file.name for file in read}
    missed = [
        name
        for name in sorted(set(names) - read_names)
        if any(not there and name.casefold().startswith(kind[:-1]) for kind, there in kinds.items())
    ]
    if not missed:
        return []
    return [f"{folder.name}: not read: {', '.join(missed)} (tables are labels.csv and landmarks.csv, or .tsv)"]


def read_indices(file: Path) -> np.ndarray:
    """(N,) int64, one number a line.

    Raises:
        InputError: a line that is no whole number.
    """
    with reading(file):
        data = file.read_bytes()
    try:
        return np.array([int(word) for word in data.decode("utf-8-sig").split()], dtype=np.int64)
    except (ValueError, OverflowError) as error:
        raise InputError(f"{file}: expected whole numbers, one a line: {error}") from error
