"""`task=model`: what a formula explains of shapes, how sure that is, and where."""

import logging
from pathlib import Path

from lssd_learn.errors import check_whole
from lssd_learn.exploration.models.known import ask
from lssd_learn.exploration.models.strata import strata
from lssd_learn.exploration.models.table import model_table, rows
from lssd_learn.exploration.models.vectors import model_vectors
from lssd_learn.pieces import Pieces
from lssd_learn.rows import write_rows

log = logging.getLogger(__name__)


def run(
    pieces: Pieces,
    out: Path,
    formula: str,
    blocks: str | None = None,
    sums: str = "I",
    permutations: int = 999,
) -> dict[str, float]:
    """Write model.csv.

    Args:
        formula: the columns that shapes are explained by, see `design`, such as "~ log(size) + sex".
        blocks: a grouping of shapes that belong together, see `strata`.
        sums: type of the sums of squares, I, II or III.
        permutations: how many; where there are no more than that, each is taken once.

    Returns:
        "shapes", and of each kind of operator and term R2, F, Z and p, as area/sex/p.

    Raises:
        InputError: as `ask`, `strata` and `model_table`; arguments out of range.
    """
    check_whole("task.permutations", permutations, 1)
    pipeline = pieces.pipeline
    asked = ask(pipeline.collection, formula, blocks)
    parts = strata(asked.design, asked.blocks, blocks or "", permutations, pieces.seed)
    operators = pipeline.operators(pieces.operators)[asked.shapes]
    tables = {
        kind: model_table(Y, asked.design, parts, sums)
        for kind, Y in model_vectors(operators, pieces.operators).items()
    }
    found = rows(tables)
    write_rows(found, out / "model.csv")
    for row in found:
        cells = [f"{row[key]:>9.4g}" if key in row else " " * 9 for key in ("df", "SS", "R2", "F", "Z", "p")]
        log.info("  %-14s %-24s %s", row["operator"], row["term"], " ".join(cells))
    log.info("%d shapes: model.csv", len(asked.shapes))
    numbers = ("R2", "F", "Z", "p")
    scored = {f"{row['operator']}/{row['term']}/{key}": row[key] for row in found for key in numbers if key in row}
    return {"shapes": len(asked.shapes), **scored}
