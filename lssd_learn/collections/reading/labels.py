"""`labels.csv`, what is known of each shape: numbers, which are targets, and groups. Used by `folder.py`."""

import logging
from collections.abc import Collection, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from lssd_learn.collections.reading.names import Names
from lssd_learn.collections.reading.numbers import MISSING, Mixed, Numbers, is_number, read_numbers
from lssd_learn.collections.reading.table import Table, read_table
from lssd_learn.collections.reading.targets import counts_rows, why_no_target
from lssd_learn.errors import InputError, some_of

log = logging.getLogger(__name__)

CODES = (-9, -99, -999, -9999, -99999, 999, 9999, 99999)  # that stand for a number nobody knows, if far from the others


@dataclass(frozen=True, eq=False)
class Labels:
    """What `labels.csv` says of n shapes.

    Attributes:
        parameters: (n, p) float64, or None without a target.
        parameter_names: p of them.
        groups: name → (n,) labels as written.
        left_out: columns of numbers that are no targets → why.
        covariates: their numbers (n,), nan where unknown.
    """

    parameters: np.ndarray | None
    parameter_names: list[str]
    groups: dict[str, np.ndarray]
    left_out: dict[str, str] = field(default_factory=dict)
    covariates: dict[str, np.ndarray] = field(default_factory=dict)

    def lacks(self, what: str, name: str | None = None) -> str:
        """Why there are no `groups` or `parameters`, or not the group of a name, in words for the message of a task."""
        numbers = [*self.parameter_names, *self.left_out]
        if what == "groups" and (name in numbers or (name is None and numbers)):
            some = numbers if name is None else [name]
            verb = "is taken as numbers" if len(some) == 1 else "are taken as numbers"
            return f"{', '.join(some)} {verb}, and collection.groups=[{some[0]}] makes a group of {some[0]}"
        if what == "parameters" and self.left_out:
            columns = ", ".join(f"{column} ({why})" for column, why in self.left_out.items())
            return f"no targets unless collection.parameters=[…] names them: {columns}"
        if what == "parameters" and self.groups:
            some = ", ".join(f"{column} (such as {str(labels[0])!r})" for column, labels in self.groups.items())
            return (
                f"the columns of labels.csv are groups: {some}; a target is all numbers, and not in collection.groups"
            )
        return "labels.csv has no column for that"


def read_labels(
    path: Path,
    names: Names | Sequence[str],
    groups: Collection[str] = (),
    parameters: Collection[str] | None = None,
    covariates: Collection[str] = (),
) -> Labels:
    """Read `labels.csv`: a column of numbers is a parameter, any other a group.

    Numbers may have a comma as their decimal sign, and a unit behind them, the same in all cells.

    Args:
        path: the file; one of its columns is called `name`.
        names: of the shapes; each must have exactly one row.
        groups: columns that are groups even if they hold numbers.
        parameters: columns that are targets; None is all of numbers but those that number the shapes (`id`) and those
            that are the same for all.
        covariates: columns that are no targets, and may be unknown of some shapes: an empty cell, or such as "n/a".

    Raises:
        InputError: a name without a row, with two, or unknown; an empty cell; a number that is missing (such as
            "n/a") among others, or can be read in two ways; a column that is asked for and not there, in two of the
            lists, or no numbers among `parameters`.
    """
    table = read_table(path, required=("name",))
    names = names if isinstance(names, Names) else Names(names)
    columns = [column for column in table.columns if column != "name"]
    for column in (*groups, *(parameters or ()), *covariates):
        if column not in columns:
            where = "parameters" if column in (parameters or ()) else "covariates"
            to = "to group by" if column in groups else f"of collection.{where}"
            raise InputError(f"{path}: expected a column {column!r} {to}, got {', '.join(columns) or 'none'}")
        if parameters is not None and column in groups and column in parameters:
            raise InputError(f"collection.groups, collection.parameters: expected {column!r} in one of them, got both")
        if column in covariates and column in (*groups, *(parameters or ())):
            other = "groups" if column in groups else "parameters"
            raise InputError(f"collection.{other}, collection.covariates: expected {column!r} in one of them, got both")
    rows = _rows(table, names, [column for column in columns if column not in covariates])

    numbers: dict[str, Numbers] = {}
    grouped: dict[str, np.ndarray] = {}
    for column in columns:
        texts = [table.columns[column][row] for row in rows]
        found = None if column in groups else _numbers(table, column, texts, names.names, column in covariates)
        if found is not None:
            numbers[column] = found
        elif parameters is not None and column in parameters:
            word = next(text for text in texts if read_numbers([text]) is None)
            raise InputError(f"{path}: expected numbers in column {column!r} of collection.parameters, got {word!r}")
        else:
            unknown = MISSING if column in covariates else ()
            grouped[column] = np.array(["" if text.casefold() in unknown else text for text in texts])
    _check_signs(table, numbers, rows)

    left_out = {
        column: "a covariate" if column in covariates else why_no_target(column, found.values)
        for column, found in numbers.items()
    }
    if parameters is None:
        targets = [column for column in numbers if left_out[column] is None]
    else:
        targets = [column for column in numbers if column in parameters]
        left_out = dict.fromkeys(numbers, "not among collection.parameters")
    _tell(path, {column: numbers[column] for column in targets}, names.names)
    left_out = {column: str(left_out[column]) for column in numbers if column not in targets}
    if left_out and parameters is None:
        why = ", ".join(f"{column} ({reason})" for column, reason in left_out.items())
        log.info("%s: no targets unless collection.parameters=[…] names them: %s", path, why)
    array = np.array([numbers[column].values for column in targets]).T if targets else None
    return Labels(array, targets, grouped, left_out, {column: numbers[column].values for column in left_out})


def _rows(table: Table, names: Names, columns: Sequence[str]) -> list[int]:
    """The row of each shape."""
    rows = [-1] * len(names)
    for row, name in enumerate(table.columns["name"]):
        i = names.position(name, table.where(row))
        if rows[i] >= 0:
            raise InputError(f"{table.where(row)}: expected one row a shape, got a second one for {name!r}")
        rows[i] = row
    for column in columns:
        if "" in table.columns[column]:
            row = table.columns[column].index("")
            raise InputError(f"{table.where(row)}: expected a value in column {column!r}, got an empty cell")
    absent = [name for name, row in zip(names.names, rows, strict=True) if row < 0]
    if absent:
        none = some_of([repr(name) for name in absent], 1)
        raise InputError(f"{table.path}: expected a row for every shape, got none for {none}")
    return rows


def _numbers(
    table: Table, column: str, texts: Sequence[str], names: Sequence[str], may_lack: bool = False
) -> Numbers | None:
    """A column as numbers, None for a group; nan what it may lack."""
    codes = {text for text in set(texts) if text.casefold() in MISSING or not text}
    unknown = [i for i, text in enumerate(texts) if text in codes] if codes else []
    known = [text for text in texts if text not in codes] if codes else texts
    try:
        found = read_numbers(known, table.separator) if known else None
    except Mixed as error:
        raise InputError(f"{table.path}: column {column!r}: {error} (or the column among collection.groups)") from None
    if found is not None and unknown and may_lack:
        values = np.full(len(texts), np.nan)
        values[[text not in codes for text in texts]] = found.values
        return replace(found, values=values)
    if found is not None and unknown:
        i = unknown[0]
        raise InputError(
            f"{table.path}: expected a number in column {column!r} for {names[i]!r}, as there are others (or the "
            f"column among collection.groups, or of those that may lack some, collection.covariates), got {texts[i]!r}"
        )
    if found is None:
        words = [text for text in dict.fromkeys(known) if not is_number(text)]
        if len(words) < len(set(known)):
            # A word among numbers is a slip more often than a group.
            level = logging.WARNING if 2 * len(words) < len(set(known)) else logging.INFO
            log.log(level, "%s: column %r is not all numbers (%r), so it is a group", table.path, column, words[0])
        return None
    if found.unit or found.comma:
        how = [f"in {found.unit!r}"] * bool(found.unit) + ["with a decimal comma"] * found.comma
        first = f"{texts[0]!r} is {found.values[0]:g}"
        log.info("%s: column %r is read as numbers %s: %s", table.path, column, " ".join(how), first)
    return found


def _check_signs(table: Table, numbers: dict[str, Numbers], rows: Sequence[int]) -> None:
    """Points in one column and commas in another: 1.234 may then be a thousand."""
    commas = [column for column, found in numbers.items() if found.comma]
    if not commas:
        return
    points = [column for column in numbers if column not in commas]
    points = [column for column in points if any("." in table.columns[column][row] for row in rows)]
    if points:
        raise InputError(
            f"{table.path}: expected one decimal sign, column {points[0]!r} has points and column {commas[0]!r} commas"
        )


def _tell(path: Path, targets: dict[str, Numbers], names: Sequence[str]) -> None:
    """Warn of targets that may be none: a count of the rows, a code for a number nobody knows."""
    for column, found in targets.items():
        if counts_rows(found.values):
            log.warning(
                "%s: column %r counts the shapes; if it is no target, name those that are: collection.parameters=[…]",
                path,
                column,
            )
        for code in CODES:
            at = np.flatnonzero(found.values == code)
            rest = found.values[found.values != code]
            if len(at) and len(rest) and abs(code - np.median(rest)) > 10 * max(np.ptp(rest), abs(np.median(rest))):
                log.warning(
                    "%s: column %r is %d for %r: a number, though it looks like a code for an unknown one",
                    path,
                    column,
                    code,
                    names[at[0]],
                )
