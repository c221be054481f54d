"""Files that a run leaves: there whole or not at all, and tables, rows by name to a CSV file."""

import csv
import os
import uuid
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, cast

import numpy as np


@contextmanager
def whole(path: Path) -> Iterator[Path]:
    """A file beside `path` to write into, which becomes it in the end; after an error there is none, and what was
    there stays."""
    draft = path.with_name(f".{path.name}.{uuid.uuid4().hex[:8]}.draft")
    try:
        yield draft
        os.replace(draft, path)
    finally:
        draft.unlink(missing_ok=True)


def write_arrays(arrays: Mapping[str, object], path: Path) -> Path:
    """Named arrays as one .npz file, the same bytes for the same arrays, in a folder that is made where there is none.

    Returns:
        Its path, which ends in .npz.
    """
    path = path if path.suffix == ".npz" else path.with_name(f"{path.name}.npz")
    path.parent.mkdir(parents=True, exist_ok=True)
    with whole(path) as draft, draft.open("wb") as stream:
        np.savez(stream, **cast(dict[str, Any], dict(arrays)))  # else taken for its options
    return path


def write_rows(rows: Iterable[Mapping[str, object]], path: Path) -> None:
    """A line a row under its columns, in the order they first appear; what a row lacks stays empty.

    Floats get six digits, whatever else there is is written as it is.
    """
    rows = list(rows)
    with whole(path) as draft, draft.open("w", newline="", encoding="utf-8") as stream:
        table = csv.DictWriter(stream, list(dict.fromkeys(key for row in rows for key in row)), restval="")
        table.writeheader()
        for row in rows:
            table.writerow({key: f"{x:.6g}" if isinstance(x, float) else x for key, x in row.items()})


def write_columns(columns: Mapping[str, Sequence[object]], path: Path) -> None:
    """The same from columns of equal length."""
    write_rows((dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)), path)
