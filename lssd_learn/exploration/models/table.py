"""The table of a multivariate linear model: what each term explains of shapes, and how sure that is."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float

from lssd_learn.errors import InputError
from lssd_learn.exploration.models.design import ModelDesign
from lssd_learn.exploration.models.effects import Chance, corrected
from lssd_learn.exploration.models.residuals import permuted_sums
from lssd_learn.exploration.models.strata import Stratum, bases, ensure_testable, orthonormal

NUMBERS = ("R2", "F", "Z", "p")  # that are worth keeping of a term
COLUMNS = ("df", "SS", *NUMBERS)


@dataclass(frozen=True, eq=False)
class TermRow:
    """A row of the table.

    Attributes:
        term: its name; of what it does between blocks, if it does something within them too, with that behind it.
        df, SS, R2: degrees of freedom, sum of squares, its part of the total.
        F: (SS / df) over that of the residuals of the same comparison.
        chance: F under permutations, its p and Z.
    """

    term: str
    df: int
    SS: float
    R2: float
    F: float
    chance: Chance


@dataclass(frozen=True, eq=False)
class ModelTable:
    """Rows of terms, and of residuals: name → (df, SS, R2), the last being the total."""

    terms: list[TermRow]
    rest: dict[str, tuple[int, float, float]]

    def row(self, term: str) -> TermRow:
        """The row of a term."""
        return next(row for row in self.terms if row.term == term)


def model_table(
    Y: Float[np.ndarray, "n r"], design: ModelDesign, parts: Sequence[Stratum], kind: str = "I"
) -> ModelTable:
    """Sums of squares of the terms of a design in data Y, as `procD.lm` of geomorph has them.

    Args:
        Y: n shapes as vectors; only their inner products matter.
        design: of the n.
        parts: its `strata`.
        kind: of sums of squares, see `bases`.

    Raises:
        InputError: as `ensure_testable`; vectors that are all the same.
    """
    ensure_testable(design, parts, kind)
    Y = Y - Y.mean(0)
    total, found, rest = float(np.square(Y).sum()), [], {}
    if total == 0:
        raise InputError("operators: expected shapes that differ, got all the same")
    within = {name for part in parts if not part.name for name, _, _ in bases(part, design, kind)}
    for part in parts:
        carried, Q = part.carry @ Y, orthonormal(part.X)
        free = part.free - Q.shape[1]
        for name, U, R in bases(part, design, kind) if free > 0 else ():
            term, left = permuted_sums(carried, U, R, Q, part.rows)
            F = (term / U.shape[1]) / np.maximum(left / free, np.finfo(float).tiny)
            named = f"{name} ({part.name})" if part.name and name in within else name
            SS = float(term[0])
            found.append(TermRow(named, U.shape[1], SS, SS / total, float(F[0]), Chance(F, part.exact)))
        left = float(np.square(carried - Q @ (Q.T @ carried)).sum())
        rest[f"residuals ({part.name})" if part.name else "residuals"] = (free, left, left / total)
    rest["total"] = (len(Y) - 1, total, 1.0)
    return ModelTable(found, rest)


def rows(tables: Mapping[str, ModelTable]) -> list[dict[str, Any]]:
    """The tables of several kinds of operators as one: a row a term, `p corrected` over the kinds where there are some.

    Args:
        tables: kind → the table, all under the same permutations.
    """
    several = len(tables) > 1
    found: list[dict[str, Any]] = []
    together = {
        row.term: corrected(np.stack([table.row(row.term).chance.found for table in tables.values()]))
        for row in next(iter(tables.values())).terms
    }
    for place, (kind, table) in enumerate(tables.items()):
        for row in table.terms:
            known = {"operator": kind, "term": row.term, "df": row.df, "SS": row.SS, "R2": row.R2, "F": row.F}
            more = {"p corrected": float(together[row.term][place])} if several else {}
            found.append(known | {"Z": row.chance.Z, "p": row.chance.p, "p smallest": row.chance.smallest} | more)
        for name, (df, SS, R2) in table.rest.items():
            found.append({"operator": kind, "term": name, "df": df, "SS": SS, "R2": R2})
    return found


def lines(found: Sequence[Mapping[str, Any]]) -> list[str]:
    """`rows` as text, for a log."""
    said = [[f"{row[key]:.4g}" if key in row else "" for key in COLUMNS] for row in found]
    named = [[row["operator"], row["term"]] for row in found]
    table = [["", "", *COLUMNS], *(name + cells for name, cells in zip(named, said, strict=True))]
    widths = [max(len(row[place]) for row in table) for place in range(len(table[0]))]
    return [
        "  ".join(cell.ljust(wide) if place < 2 else cell.rjust(wide) for place, (cell, wide) in enumerate(each))
        for each in (list(zip(row, widths, strict=True)) for row in table)
    ]
