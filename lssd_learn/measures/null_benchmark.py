"""`task=null_benchmark`: how often a linear model finds something where there is nothing.

Shapes get random groups and random numbers, again and again; the formula may have a nuisance beside them, as pose or
size, and blocks. A test at 5 % is to find something in 5 % of such studies, in the table and anywhere on the surface.
"""

import logging
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from lssd_learn.collections.columns import available, columns
from lssd_learn.collections.groups import read_labels
from lssd_learn.errors import check_whole
from lssd_learn.exploration.blocks import block_codes
from lssd_learn.exploration.models.clusters import Cells
from lssd_learn.exploration.models.design import design, needed
from lssd_learn.exploration.models.effects import Chance
from lssd_learn.exploration.models.points import anywhere, local_sizes
from lssd_learn.exploration.models.strata import strata
from lssd_learn.exploration.models.table import model_table
from lssd_learn.exploration.models.vectors import TOGETHER, model_vectors
from lssd_learn.operators.vectors import live_functions
from lssd_learn.pieces import Pieces
from lssd_learn.progress import track
from lssd_learn.written import write_rows

log = logging.getLogger(__name__)

CHANCE, LEVEL = "chance", 0.05
PLACES = ("anywhere", "enhanced")  # the largest statistic on the surface, and the largest after enhancement


def run(
    pieces: Pieces,
    out: Path,
    nuisance: str | None = None,
    blocks: str | None = None,
    studies: int = 1000,
    permutations: int = 199,
    points: int = 300,
) -> dict[str, float]:
    """Write null.csv: of random groups and numbers, with blocks within these and between, how often p is at most .05.

    Args:
        nuisance: terms beside the random one, such as "log(size) + pose"; None is none.
        blocks: a grouping of shapes that belong together, see `strata`.
        studies: of each kind.
        permutations: of each study.
        points: vertices, spread over the first shape, at which the model is asked too.

    Returns:
        area/groups/table, area/groups/anywhere and area/groups/enhanced, the parts of the studies, and so on.

    Raises:
        InputError: as `task=model`; arguments out of range.
    """
    check_whole("task.studies", studies, 1)
    check_whole("task.permutations", permutations, 19)
    check_whole("task.points", points, 1)
    pipeline, kinds = pieces.pipeline, list(pieces.operators)
    collection, latent, _ = pipeline.collection, pipeline.latent, pipeline.bases
    operators = pipeline.operators(kinds)
    of = None if blocks is None else block_codes(read_labels(collection, blocks, "task.blocks"), len(collection))
    formula = f"~ {CHANCE}" if nuisance is None else f"~ {nuisance} + {CHANCE}"
    known = {} if nuisance is None else columns(collection, needed(f"~ {nuisance}", available(collection)))
    live, cells = live_functions(operators), Cells.of(collection[0], points)
    sizes = {kind: local_sizes(latent, operators[:, c], 0, live[c])[:, cells.chosen] for c, kind in enumerate(kinds)}
    vectors = model_vectors(operators, kinds)

    found: dict[str, list[float]] = {}
    rng = np.random.default_rng(pieces.seed)
    for _ in track(range(studies), "studies of nothing"):
        for title, values in _draws(len(collection), of, rng):
            made = design(formula, known | {CHANCE: values}, collection.names)
            term = next(term for term in made.terms if term.name == CHANCE)
            parts = strata(made, of, blocks or "", permutations, int(rng.integers(2**31)))
            within = "between" not in title
            part = next(part for part in parts if within == (not part.name))
            for kind, Y in vectors.items():
                p = model_table(Y, made, parts, "II").row(CHANCE).chance.p
                found.setdefault(f"{kind}/{title}/table", []).append(p)
            chances = anywhere(sizes, made, term, part, cells)
            if len(kinds) > 1:
                largest, widest = np.max([[chance.found for chance in of] for of in chances.values()], axis=0)
                chances[TOGETHER.join(kinds)] = Chance(largest, part.exact), Chance(widest, part.exact)
            for kind, several in chances.items():
                for where, chance in zip(PLACES, several, strict=True):
                    found.setdefault(f"{kind}/{title}/{where}", []).append(chance.p)
    rates = {name: float(np.mean(np.array(p) <= LEVEL)) for name, p in found.items()}
    known_rows = {"nuisance": nuisance or "", "blocks": blocks or "", "studies": studies}
    rows = [dict(zip(("operator", "what", "where"), name.split("/"), strict=True)) for name in rates]
    write_rows([known_rows | row | {"rate": rate} for row, rate in zip(rows, rates.values(), strict=True)],
               out / "null.csv")  # fmt: skip
    for name, rate in rates.items():
        log.info("  %-44s %5.1f %% of %d studies at most .05", name, 100 * rate, studies)
    log.info("null.csv")
    return rates


def _draws(n: int, blocks: np.ndarray | None, rng: np.random.Generator) -> Iterator[tuple[str, np.ndarray]]:
    """What is random and its column: halves of the shapes and numbers; with blocks, of the shapes within each block and
    of the blocks."""
    if blocks is None:
        yield "groups", np.array(["a", "b"], dtype=object)[rng.permutation(np.arange(n) % 2)]
        yield "numbers", rng.normal(size=n)
        return
    of = np.unique(blocks, return_inverse=True)[1]
    labels = np.empty(n, dtype=object)
    for block in np.unique(of):
        some = np.flatnonzero(of == block)
        labels[some] = np.array(["a", "b"], dtype=object)[rng.permutation(np.arange(len(some)) % 2)]
    yield "groups within", labels
    whole = rng.permutation(np.arange(of.max() + 1) % 2)[of]
    yield "groups between", np.array(["a", "b"], dtype=object)[whole]
    yield "numbers between", rng.normal(size=of.max() + 1)[of]
