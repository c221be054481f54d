"""The table of a multivariate linear model: what each term explains of shapes, and how sure that is."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from jaxtyping import Float

from lssd_learn.errors import InputError
from lssd_learn.exploration.models.design import ModelDesign
from lssd_learn.exploration.models.effects import Chance, chance, corrected
from lssd_learn.exploration.models.residuals import permuted_sums
from lssd_learn.exploration.models.strata import Stratum, bases, orthonormal


@dataclass(frozen=True, eq=False)
class TermRow:
    """A row of the table.

    Attributes:
        term: its name; of what it does between blocks, if it does something within them too, with that behind it.
        df, SS, R2: degrees of freedom, sum of squares, its part of the total.
        F: (SS / df) over that of the residuals of the same comparison.
        chance: p and Z of F.
        permuted: (N,) F under permutations, that of the data first.
    """

    term: str
    df: int
    SS: float
    R2: float
    F: float
    chance: Chance
    permuted: Float[np.ndarray, " N"]


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
        InputError: as `bases`; a term that says nothing that others do not; no residuals.
    """
    Y = Y - Y.mean(0)
    total, found, rest = float(np.square(Y).sum()), [], {}
    if total == 0:
        raise InputError("operators: expected shapes that differ, got all the same")
    within = {name for part in parts if not part.name for name, _, _ in bases(part, design, kind)}
    for part in parts:
        carried, Q = part.carry @ Y, orthonormal(part.X)
        free = part.free - Q.shape[1]
        if free < 1 and not part.name:
            raise InputError(
                f"task.formula={design.formula}: expected fewer terms, {part.free} differences of shapes leave no "
                f"residuals beside {Q.shape[1]} columns"
            )
        for name, U, R in bases(part, design, kind) if free > 0 else ():
            term, left = permuted_sums(carried, U, R, Q, part.rows)
            F = (term / U.shape[1]) / np.maximum(left / free, np.finfo(float).tiny)
            named = f"{name} ({part.name})" if part.name and name in within else name
            SS = float(term[0])
            found.append(TermRow(named, U.shape[1], SS, SS / total, float(F[0]), chance(F, part.exact), F))
        left = float(np.square(carried - Q @ (Q.T @ carried)).sum())
        rest[f"residuals ({part.name})" if part.name else "residuals"] = (free, left, left / total)
    if lost := [term.name for term in design.terms if not any(_is(row.term, term.name) for row in found)]:
        raise InputError(
            f"task.formula={design.formula}: expected terms that say something of their own, {lost[0]} does not"
        )
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
        row.term: corrected(np.stack([table.row(row.term).permuted for table in tables.values()]))
        for row in next(iter(tables.values())).terms
    }
    for place, (kind, table) in enumerate(tables.items()):
        for row in table.terms:
            known = {"operator": kind, "term": row.term, "df": row.df, "SS": row.SS, "R2": row.R2, "F": row.F}
            more = {"p corrected": float(together[row.term][place])} if several else {}
            said = asdict(row.chance)
            found.append(known | {"Z": said["Z"], "p": said["p"], "p smallest": said["smallest"]} | more)
        for name, (df, SS, R2) in table.rest.items():
            found.append({"operator": kind, "term": name, "df": df, "SS": SS, "R2": R2})
    return found


def _is(row: str, term: str) -> bool:
    return row == term or row.startswith(f"{term} (between ")
