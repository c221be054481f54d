"""Tables that tasks leave: rows by name to a CSV file."""

import csv
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path


def write_rows(rows: Iterable[Mapping[str, object]], path: Path) -> None:
    """A line a row under its columns, in the order they first appear; what a row lacks stays empty.

    Floats get six digits, whatever else there is is written as it is.
    """
    rows = list(rows)
    with path.open("w", newline="", encoding="utf-8") as stream:
        table = csv.DictWriter(stream, list(dict.fromkeys(key for row in rows for key in row)), restval="")
        table.writeheader()
        for row in rows:
            table.writerow({key: f"{x:.6g}" if isinstance(x, float) else x for key, x in row.items()})


def write_columns(columns: Mapping[str, Sequence[object]], path: Path) -> None:
    """The same from columns of equal length."""
    write_rows((dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)), path)
