"""`task=power_benchmark`: whether a linear model finds a change that is there, and where.

In each study half of some people have a place of theirs grown (`collection=grown`), beside what else they differ by;
or, paired, each is there before and after. Beside the operators' answer stands that of landmarks: Procrustes analysis,
the same model of their coordinates, and the thin-plate spline between the two means. These are known vertices, also
where each body has a mesh of its own (`collection=remeshed_grown`) and the operators come from maps that are computed.
"""

import logging
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import cast

import numpy as np

from lssd_learn.collections import Collection, Grown, Remeshed
from lssd_learn.collections.columns import available, columns
from lssd_learn.errors import InputError, check_whole
from lssd_learn.exploration.models.clusters import Cells
from lssd_learn.exploration.models.design import design, needed
from lssd_learn.exploration.models.points import PointField, local_sizes, term_fields
from lssd_learn.exploration.models.strata import orthonormal, strata
from lssd_learn.exploration.models.table import model_table
from lssd_learn.exploration.models.vectors import model_vectors
from lssd_learn.exploration.scores import area_under_curve, strongest
from lssd_learn.exploration.template import aligned_landmarks, template_log_ratio
from lssd_learn.operators.vectors import live_functions
from lssd_learn.pieces import Pieces
from lssd_learn.progress import track
from lssd_learn.shapes import Mesh
from lssd_learn.shapes.sampling import farthest_points
from lssd_learn.written import write_rows

log = logging.getLogger(__name__)

LEVEL, STATE = 0.05, "state"
NOWHERE = 0.02  # a change below this part of its 99th percentile is none
TABLE = "power.csv"


@dataclass(frozen=True, eq=False)
class Study:
    """Which bodies, and the blocks of a paired one."""

    shapes: np.ndarray
    blocks: np.ndarray | None


def run(
    pieces: Pieces,
    out: Path,
    nuisance: str | None = "weight + pose",
    paired: bool = False,
    people: int = 40,
    studies: int = 100,
    permutations: int = 199,
    landmarks: int = 51,
    points: int = 200,
) -> dict[str, float]:
    """Write power.csv: how often the change is found, and how well its place.

    Args:
        nuisance: terms beside the state, None is none.
        paired: each person before and after, and nothing else taken into account; else half of the people grown.
        people: of each study.
        studies: how many.
        permutations: of each.
        landmarks: vertices spread over a body.
        points: that stand for the surface in the enhancement.

    Returns:
        Of the operators: p of the table, the mean; table, anywhere, enhanced, the parts of the studies with p at most
        .05; auc of |t| over the surface; dice of the significant region, and of its `core` and the enhanced one; false,
        the share of the significant area where nothing changes, and stray, how often that is more than a tenth (also of
        the core). Of landmarks: landmarks/table, landmarks/auc, landmarks/dice.

    Raises:
        InputError: a collection whose change is not known, clouds; arguments out of range.
    """
    collection = pieces.pipeline.collection
    bodies, origins = _known(collection)
    n = len(collection) // 2
    check_whole("task.people", people, 4, n)
    check_whole("task.studies", studies, 1)
    check_whole("task.permutations", permutations, 19)
    check_whole("task.landmarks", landmarks, 4)
    check_whole("task.points", points, 1)
    latent, _ = pieces.pipeline.latent, pieces.pipeline.bases
    operators = pieces.pipeline.operators(pieces.operators)
    kind, live = pieces.operators[0], live_functions(operators)
    shown = cast(Mesh, collection[0])
    truth, mass, cells = bodies.log_area_ratio[origins], shown.vertex_areas, Cells.of(shown, points)
    sizes = local_sizes(latent, operators[:, 0], 0, live[0])
    first = bodies[0]
    at = farthest_points(first.vertices, landmarks)
    marks = np.stack([bodies[i].vertices[at] for i in range(len(bodies))])
    formula = f"~ {STATE}" if paired or nuisance is None else f"~ {nuisance} + {STATE}"
    known = columns(collection, needed(formula, available(collection)))
    found: list[dict[str, float]] = []
    rng = np.random.default_rng(pieces.seed)
    for study in track(list(_studies(n, people, studies, paired, rng)), "studies"):
        some, names = study.shapes, [str(collection.names[i]) for i in study.shapes]
        made = design(formula, {name: values[some] for name, values in known.items()}, names)
        part = strata(made, study.blocks, "person", permutations, int(rng.integers(2**31)))[-1]
        term = next(term for term in made.terms if term.name == STATE)
        Y = model_vectors(operators[some, :1], [kind])[kind]
        field = term_fields({kind: sizes[some]}, made, term, part, mass, cells)[kind][0]
        aligned = aligned_landmarks(marks[some], scale=True)
        p = model_table(Y, made, [part], "II").row(STATE).chance.p
        row = {"p": p, "table": p <= LEVEL, **_placed(field, truth, mass)}
        Z = aligned.reshape(len(some), -1)
        row["landmarks/table"] = model_table(Z - Z.mean(0), made, [part], "II").row(STATE).chance.p <= LEVEL
        change = _change(part.carry @ Z, part.X, term.columns).reshape(landmarks, 3)
        if field.title != "plain - grown":
            change = -change
        mean = aligned.mean(0)
        ratio = template_log_ratio(first, marks[0], mean + change / 2, mean - change / 2)[origins]
        row["landmarks/auc"] = area_under_curve(np.abs(ratio), strongest(truth, mass), mass)
        row["landmarks/dice"] = dice(strongest(ratio, mass), strongest(truth, mass), mass)
        found.append({key: float(value) for key, value in row.items()})
    rates = {key: _mean(np.array([row[key] for row in found])) for key in found[0]}
    meshes = "one" if collection is bodies else "own"
    told = {"place": bodies.place, "area": bodies.area, "others": bodies.others, "meshes": meshes, "paired": paired,
            "people": people, "studies": studies, "keep": latent.keep}  # fmt: skip
    write_rows([told | rates], out / TABLE)
    for name, rate in rates.items():
        log.info("  %-20s %6.3f", name, rate)
    log.info(TABLE)
    return rates


def _mean(values: np.ndarray) -> float:
    """Of those that are known; NaN, in no study was anything significant, where none is."""
    known = values[np.isfinite(values)]
    return float(known.mean()) if len(known) else float("nan")


def _known(collection: Collection) -> tuple[Grown, np.ndarray]:
    """The bodies whose change is known, and for each vertex of the first shape the vertex of these beside it."""
    if isinstance(collection, Grown):
        return collection, np.arange(len(collection[0].vertices))
    if isinstance(collection, Remeshed) and isinstance(collection.base, Grown) and collection.kind == "mesh":
        return collection.base, collection.origins(0)
    raise InputError("task=power_benchmark: expected collection=grown or remeshed_grown, of which the truth is known")


def dice(first: np.ndarray, second: np.ndarray, mass: np.ndarray) -> float:
    """Twice the area of what two regions share over the sum of theirs; 0 where both are empty."""
    both = mass[first].sum() + mass[second].sum()
    return float(2 * mass[first & second].sum() / both) if both else 0.0


def _studies(n: int, people: int, studies: int, paired: bool, rng: np.random.Generator) -> Iterator[Study]:
    for _ in range(studies):
        some = rng.permutation(n)[:people]
        if paired:
            yield Study(np.concatenate([some, some + n]), np.tile(np.arange(people), 2))
        else:
            yield Study(some + n * (np.arange(people) % 2), None)


def _placed(field: PointField, truth: np.ndarray, mass: np.ndarray) -> dict[str, float]:
    positive = strongest(truth, mass)
    nothing = np.abs(truth) < NOWHERE * np.quantile(np.abs(truth), 0.99, weights=mass, method="inverted_cdf")

    def false(there: np.ndarray) -> float:
        return float(mass[there & nothing].sum() / mass[there].sum()) if there.any() else float("nan")

    return {
        "anywhere": field.p.min() <= LEVEL,
        "enhanced": field.p_enhanced.min() <= LEVEL,
        "auc": area_under_curve(np.abs(field.statistic), positive, mass),
        "dice": dice(field.significant, positive, mass),
        "dice/core": dice(field.core, positive, mass),
        "dice/enhanced": dice(field.p_enhanced <= LEVEL, positive, mass),
        "false": false(field.significant),
        "stray": false(field.significant) > 0.1,
        "false/core": false(field.core),
        "stray/core": false(field.core) > 0.1,
    }


def _change(Z: np.ndarray, X: np.ndarray, columns: slice) -> np.ndarray:
    """What the coordinates of bodies change along a term beside the others, as far as its two groups are apart."""
    rest = np.delete(X, np.arange(X.shape[1])[columns], axis=1)
    R = orthonormal(rest)
    x = X[:, columns][:, 0]
    x = x - R @ (R.T @ x)
    return np.ptp(X[:, columns][:, 0]) * (x @ Z) / (x @ x)
