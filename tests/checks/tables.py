"""The tables under docs/results, and their numbers as the pages write them."""

import csv
from pathlib import Path
from statistics import mean, stdev

DOCS = Path(__file__).parents[2] / "docs"
ASKED: set[str] = set()  # the tables that were read


def table(name, **where):
    """The rows of a table in which these columns say so."""
    with (DOCS / "results" / f"{name}.csv").open(encoding="utf-8", newline="") as stream:
        rows = [row for row in csv.DictReader(stream) if all(row[key] == value for key, value in where.items())]
    assert rows, (name, where)
    ASKED.add(name)
    return rows


def values(rows, column):
    return [float(row[column]) for row in rows]


def short(value, digits):
    """A number as the pages write it: .0083, without the zero, and −9.8 with a minus that is one."""
    return f"{value:.{digits}f}".replace("0.", ".", 1 if abs(value) < 1 else 0).replace("-", "−")


def spread(rows, column, digits):
    """Mean ± standard deviation."""
    found = values(rows, column)
    return f"{short(mean(found), digits)} ± {short(stdev(found), digits)}"
