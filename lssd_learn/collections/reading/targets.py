"""Which columns of numbers are targets: all but those that only number the shapes, and those that are the same for all.

Used by `labels.py`.
"""

import re

import numpy as np

# A column of this name is one of identifiers; of those below, if it holds whole numbers, each once.
IDENTIFIERS = {"id", "ids", "uid", "uuid", "pid"}
COUNTERS = {
    "index", "idx", "nr", "no", "num", "nº", "n°", "#", "number", "numbers", "row", "rownames", "rowname", "order",
    "specimen", "sample", "subject", "patient", "participant", "individual", "case", "scan", "shape", "mesh", "file",
    "accession", "catalogue", "catalog", "inventory", "record", "key", "barcode", "code", "person", "animal",
}  # fmt: skip


def why_no_target(column: str, values: np.ndarray) -> str | None:
    """Why a column of numbers is no target unless asked for; None if it is one.

    Args:
        column: its name.
        values: (n,).
    """
    words = _words(column)
    whole = (values == np.round(values)).all()
    each_once = len(np.unique(values)) == len(values)
    if len(values) > 1 and (values == values[0]).all():
        return f"{values[0]:g} for all"
    if IDENTIFIERS & set(words[:1] + words[-1:]) or (words[-1] in COUNTERS and whole and each_once and len(values) > 1):
        return "identifies shapes"
    return None


def counts_rows(values: np.ndarray) -> bool:
    """Whether a column is 0, 1, 2, … or 1, 2, 3, … from the first shape to the last, as a forgotten index is."""
    n = len(values)
    return n > 2 and any(np.array_equal(values, np.arange(first, first + n)) for first in (0, 1))


def _words(column: str) -> list[str]:
    """`SpecimenID`, `specimen_id` and `specimen id` are the words specimen, id."""
    apart = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", column)
    return [word for word in re.split(r"[\s_.\-:/()]+", apart.casefold()) if word] or [column.casefold()]
