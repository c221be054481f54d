"""The door to landmark files: which format a file has, by its name and content; one clear line for what is none."""

import re
from collections.abc import Sequence
from pathlib import Path

from lssd_learn.collections.landmark_files import fcsv, morphoj, morphologika, mrk_json, pts, tps
from lssd_learn.collections.landmark_files.specimen import Specimen
from lssd_learn.collections.reading.names import composed
from lssd_learn.errors import InputError, reading
from lssd_learn.shapes.reading.words import text_of
from lssd_learn.written import whole

ONE_SPECIMEN = (".mrk.json", ".mkp.json", ".fcsv", ".pts")  # formats of which a file holds one specimen
MANY = (".tps", ".txt", ".csv", ".tsv")
TABLES = (".txt", ".csv", ".tsv")  # Morphologika or MorphoJ, by what is in them
_FORMATS = {
    "mrk.json": mrk_json,
    "fcsv": fcsv,
    "pts": pts,
    "tps": tps,
    "morphologika": morphologika,
    "morphoj": morphoj,
}
FORMATS = tuple(_FORMATS)
SUFFIXES = {"morphologika": ".txt", "morphoj": ".txt"}  # of the others it is the format's name


def suffix_of(name: str) -> str:
    """The suffix of a landmark file, such as `.mrk.json`, in small letters; "" for other files."""
    name = name.casefold()
    return next((suffix for suffix in (*ONE_SPECIMEN, *MANY) if name.endswith(suffix)), "")


def read_specimens(path: Path) -> list[Specimen]:
    """Read a landmark file, several specimens of a `.tps`, Morphologika or MorphoJ file, one of any other.

    A specimen that its file does not name has the name of the file.

    Raises:
        InputError: no such file, another format, a damaged file, two specimens of one name.
    """
    suffix = suffix_of(path.name)
    if not suffix:
        raise InputError(f"{path}: expected landmarks ({' '.join((*ONE_SPECIMEN, *MANY))}), got {path.name}")
    with reading(path):
        data = path.read_bytes()
    try:
        text = composed(text_of(data)).removeprefix("\ufeff")
        if not text.strip():
            raise ValueError("the file is empty")
        found = _module(suffix, text).read(text)
        stem = composed(path.name[: -len(suffix)])
        found = [one if one.name else Specimen(stem, one.labels, one.points, one.space, one.notes) for one in found]
        names = [one.name for one in found]
        twice = next((name for name in names if names.count(name) > 1), None)
        if twice is not None:
            raise ValueError(f"expected each specimen once, got {twice!r} again")
    except (ValueError, UnicodeError) as error:
        raise InputError(f"{path}: {error}") from None
    return found


def _module(suffix: str, text: str):
    if suffix in TABLES:
        return morphologika if morphologika.is_morphologika(text) else morphoj
    return mrk_json if suffix == ".mkp.json" else _FORMATS[suffix[1:]]


def write_specimens(specimens: Sequence[Specimen], folder: Path, form: str, name: str = "landmarks") -> list[Path]:
    """Write landmarks in a format: a file a specimen, named after it, or one file NAME for all.

    Args:
        specimens: one or more, each with a name of its own.
        folder: that exists.
        form: one of `FORMATS`.
        name: of the one file for all, without a suffix.

    Returns:
        The files.

    Raises:
        InputError: an unknown format, no specimen, a folder that is not there, specimens that do not fit together.
    """
    if form not in FORMATS:
        raise InputError(f"expected a format of landmarks, one of {', '.join(FORMATS)}, got {form!r}")
    if not specimens or not folder.is_dir():
        raise InputError(f"{folder}: expected {'landmarks to write' if not specimens else 'a folder, it is not there'}")
    suffix = SUFFIXES.get(form, f".{form}")
    if suffix in ONE_SPECIMEN:
        plain = [re.sub(r"[/\\\0]", "_", one.name) for one in specimens]  # what a file name may not hold
        parts = [(folder / f"{stem}{suffix}", [one]) for stem, one in zip(plain, specimens, strict=True)]
    else:
        parts = [(folder / f"{name}{suffix}", list(specimens))]
    for path, some in parts:
        try:
            text = _FORMATS[form].write(some)
        except ValueError as error:
            raise InputError(f"{path}: {error}") from None
        with whole(path) as draft:
            draft.write_text(text, encoding="utf-8", newline="\n")
    return [path for path, _ in parts]
