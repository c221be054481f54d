"""All that a formula tells of shapes: what `task=model` writes."""

import logging
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from jaxtyping import Float
from torch import Tensor

from lssd_learn.exploration.models import pairwise, table
from lssd_learn.exploration.models.allometry import regression_scores, without
from lssd_learn.exploration.models.clusters import Cells
from lssd_learn.exploration.models.known import Asked
from lssd_learn.exploration.models.pairwise import Compared, compare_pairs, place
from lssd_learn.exploration.models.points import PointField, local_sizes, term_fields
from lssd_learn.exploration.models.strata import Stratum
from lssd_learn.exploration.models.table import ModelTable, model_table
from lssd_learn.exploration.models.vectors import model_vectors
from lssd_learn.latent import LatentSpace
from lssd_learn.operators.vectors import live_functions

log = logging.getLogger(__name__)

COMPONENTS = 3  # principal components among the scores


@dataclass(frozen=True, eq=False)
class Answer:
    """What a formula tells, by kind of operator; of several kinds the vectors of all together are one more.

    Attributes:
        tables: what each term explains.
        compared: groups and slopes in pairs.
        scores: column → n values: the variables, principal components and regression scores.
        corrected: kind → operators without a number of the formula, where that was asked.
        fields: where, on the surface of the shape that is shown; of kinds by themselves.
    """

    tables: dict[str, ModelTable]
    compared: dict[str, list[Compared]]
    scores: dict[str, list]
    fields: dict[str, list[PointField]]
    corrected: dict[str, Float[Tensor, "n m m"]]

    @property
    def rows(self) -> list[dict[str, Any]]:
        """The tables as one."""
        return table.rows(self.tables)

    @property
    def pairs(self) -> list[dict[str, Any]]:
        """The comparisons as a table."""
        return [row for kind, compared in self.compared.items() for row in pairwise.rows(kind, compared)]

    @property
    def components(self) -> dict[str, list]:
        """Of the scores the first two principal components of each kind."""
        return {name: values for name, values in self.scores.items() if name.endswith((" PC1", " PC2"))}

    @property
    def metrics(self) -> dict[str, float]:
        """R2, F, Z and p by kind and term, as area/sex/p; and area/sex/anywhere, the least p on the surface."""
        found = {
            f"{row['operator']}/{row['term']}/{key}": row[key]
            for row in self.rows
            for key in table.NUMBERS
            if key in row
        }
        for kind, fields in self.fields.items():
            for field in fields:
                name = f"{kind}/{field.term}/anywhere"
                found[name] = min(found.get(name, 1.0), float(field.p.min()))
        return found


def answer(
    latent: LatentSpace,
    operators: Float[Tensor, "n channels m m"],
    kinds: Sequence[str],
    asked: Asked,
    parts: Sequence[Stratum],
    sums: str,
    shown: int,
    cells: Cells,
    number: str | None = None,
) -> Answer:
    """Ask it.

    Args:
        latent: the space of the whole collection, with its eigenbases.
        operators: of the n shapes that are asked about, a channel a kind.
        kinds: their names.
        asked: the formula.
        parts: its `strata`.
        sums: type of the sums of squares in the tables.
        shown: position in the collection of the shape at whose vertices the model is asked.
        cells: of its surface.
        number: of the formula, that is taken out of the operators; None takes nothing out.

    Raises:
        InputError: as `model_table`.
    """
    vectors, made = model_vectors(operators, kinds), asked.design
    tables = {kind: model_table(Y, made, parts, sums) for kind, Y in vectors.items()}
    live = live_functions(operators)
    sizes = {kind: local_sizes(latent, operators[:, c], shown, live[c]) for c, kind in enumerate(kinds)}
    fields: dict[str, list[PointField]] = {kind: [] for kind in kinds}
    for term in made.terms:
        part, U, _ = place(parts, made, term)
        if U is None:
            log.warning("%s says nothing that the other terms do not: it has a row of type I, and no pairs or field",
                        term.name)  # fmt: skip
        else:
            for kind, found in term_fields(sizes, made, term, part, latent.eigenbasis(shown).mass, cells).items():
                fields[kind] += found
    scores = dict(made.values)
    for kind, Y in vectors.items():
        scores |= {f"{kind} PC{c + 1}": Y[:, c] for c in range(min(COMPONENTS, Y.shape[1]))}
        scores |= {f"{kind} along {number}": values for number, values in regression_scores(Y, made).items()}
    return Answer(
        tables,
        {kind: compare_pairs(Y, made, parts) for kind, Y in vectors.items()},
        {name: values.tolist() for name, values in scores.items()},
        fields,
        {} if number is None else {kind: without(operators[:, c], made, number) for c, kind in enumerate(kinds)},
    )
