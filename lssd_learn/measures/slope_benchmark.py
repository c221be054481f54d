"""`task=slope_benchmark`: how often an interval of a linear model holds the slope that is there.

People have a place of theirs grown by a share that is known of each (`collection=grown collection.dose=true`), beside
what else they differ by. What this does to the local sizes is known too: each person is there without it as well.
"""

import logging
from pathlib import Path

import numpy as np
from scipy.sparse import csr_array

from lssd_learn.collections import Grown
from lssd_learn.collections.columns import available, columns
from lssd_learn.errors import InputError, check_whole
from lssd_learn.exploration.models.clusters import Cells
from lssd_learn.exploration.models.contrasts import deviation
from lssd_learn.exploration.models.design import design, needed
from lssd_learn.exploration.models.points import local_sizes, term_fields
from lssd_learn.exploration.models.strata import strata
from lssd_learn.exploration.scores import strongest
from lssd_learn.operators.vectors import live_functions
from lssd_learn.pieces import Pieces
from lssd_learn.progress import track
from lssd_learn.written import write_rows

log = logging.getLogger(__name__)

DOSE = "dose"
TABLE = "slopes.csv"


def run(
    pieces: Pieces, out: Path, nuisance: str | None = "weight + pose", people: int = 40, studies: int = 200
) -> dict[str, float]:
    """Write slopes.csv: how often the interval of 95 % holds the slope, at a vertex and as a mean over the place.

    Args:
        nuisance: terms beside the dose, None is none.
        people: of each study.
        studies: how many.

    Returns:
        vertex, where the change is largest, place, its mean, and surface, the mean over all vertices, the parts of the
        studies; and bias, how much the mean slope over the place differs from the truth in its standard errors.

    Raises:
        InputError: a collection whose change is not known, or without doses; arguments out of range.
    """
    collection = pieces.pipeline.collection
    if not isinstance(collection, Grown) or np.ptp(collection.covariates[DOSE][len(collection) // 2 :]) == 0:
        raise InputError("task=slope_benchmark: expected collection=grown collection.dose=true")
    n = len(collection) // 2
    check_whole("task.people", people, 4, n)
    check_whole("task.studies", studies, 1)
    latent, _ = pieces.pipeline.latent, pieces.pipeline.bases
    operators = pieces.pipeline.operators(pieces.operators[:1])
    sizes = local_sizes(latent, operators[:, 0], 0, live_functions(operators)[0])
    mass = collection[0].vertex_areas
    region = strongest(collection.log_area_ratio, mass)
    weights = mass * region / mass[region].sum()
    asked = np.column_stack([sizes, sizes @ weights])
    truth = ((asked[n:] - asked[:n]) / collection.covariates[DOSE][n:, None]).mean(0)
    formula = f"~ {DOSE}" if nuisance is None else f"~ {nuisance} + {DOSE}"
    known = columns(collection, needed(formula, available(collection)))
    everywhere = csr_array(np.ones((len(truth), 1)))  # no p is asked for
    alone = Cells(np.zeros(1, dtype=int), np.ones(1), np.zeros((0, 2), dtype=int), everywhere)
    held, apart = np.zeros((studies, len(truth)), dtype=bool), np.empty(studies)
    rng = np.random.default_rng(pieces.seed)
    for b in track(range(studies), "studies"):
        some = n + rng.permutation(n)[:people]
        made = design(formula, {name: v[some] for name, v in known.items()}, [str(collection.names[i]) for i in some])
        part, term = strata(made, None, "", 1, 0)[-1], next(term for term in made.terms if term.name == DOSE)
        sd = deviation(made, DOSE)
        field = term_fields({"area": asked[some]}, made, term, part, np.ones(len(truth)), alone)["area"][0]
        held[b] = (field.low <= sd * truth) & (sd * truth <= field.high)
        apart[b] = (field.effect[-1] - sd * truth[-1]) * field.statistic[-1] / field.effect[-1]
    largest = int(np.abs(np.where(region, truth[:-1], 0)).argmax())
    rates = {
        "vertex": float(held[:, largest].mean()),
        "place": float(held[:, -1].mean()),
        "surface": float(held[:, :-1].mean(0) @ mass / mass.sum()),
        "bias": float(apart.mean()),
    }
    told = {"place grown": collection.place, "others": collection.others, "nuisance": nuisance or "", "people": people,
            "studies": studies}  # fmt: skip
    write_rows([told | rates], out / TABLE)
    log.info("the interval holds the slope in %.1f %% of %d studies at the vertex, %.1f %% over the place, %.1f %% over"
             " the surface", 100 * rates["vertex"], studies, 100 * rates["place"],
             100 * rates["surface"])  # fmt: skip
    log.info(TABLE)
    return rates
