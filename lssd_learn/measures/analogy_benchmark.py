"""`task=analogy_benchmark`: how far analogies come from their known answers.

No body of a collection stands in two poses. So bodies of another seed are made in all poses and pushed into the latent
space of the checkpoint. A is body p in pose a, B is p in pose b, C is body q in a; the truth is q in b.
"""

import logging
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import torch

from lssd_learn.collections.generated.bodies import Bodies
from lssd_learn.collections.generated.body.poses import POSE_NAMES
from lssd_learn.collections.generated.posed import Posed
from lssd_learn.errors import InputError, check_whole
from lssd_learn.learning.scores.reconstructed import SEED, means
from lssd_learn.learning.scores.reconstruction_scores import sampling_level, vertex_error
from lssd_learn.measures.quadruples import ROLES, Quadruple, draw_quadruples
from lssd_learn.models.synthesis import METHODS, answer, draw_points, open_trained, operators_of
from lssd_learn.models.trained import Trained
from lssd_learn.pieces import Pieces
from lssd_learn.progress import track
from lssd_learn.shapes import Mesh, Shape, sample
from lssd_learn.shapes.nearest import Indexed
from lssd_learn.view.sheets import shape_sheet, write_sheets
from lssd_learn.written import write_rows

log = logging.getLogger(__name__)

SHOWN = 6  # quadruples in the picture
Row = dict[str, str | float]


def run(
    pieces: Pieces,
    out: Path,
    quadruples: int = 100,
    validation: int = 50,
    bodies: int = 8,
    seed: int = 1,
    points: int = 4096,
    neighbours: int = 5,
    local: bool = True,
) -> dict[str, float]:
    """Write analogies.csv and analogies.png; print the table.

    Args:
        quadruples, validation: bodies and poses that are drawn, each asked about in both roles; by those of validation,
            of other bodies, the best method is chosen.
        bodies: in all poses, of the test; half as many more, two at least, are those of validation.
        seed: of their parameters; another than the collection's.
        points: of the true clouds, and of meshes that are compared with them.
        neighbours: training shapes that each new one is pushed from.
        local: see `open_trained`.

    Returns:
        test/<answer>/ and validation/<answer>/ with cd, cd_over_level, over_own (the mean Chamfer distance over that of
        drawing the truth from its own operator) and vertex_error_mm of meshes, for each of `METHODS`, for "own", that
        drawing, and for "C", the trivial answer; the same by role, as test/linear/pose/cd; and test/best/, the method
        with the least Chamfer distance on validation.

    Raises:
        InputError: a collection that is not of generated bodies, arguments out of range; see `open_trained`.
    """
    collection = pieces.pipeline.collection
    if not isinstance(collection, Bodies):
        raise InputError("task=analogy_benchmark: expected generated bodies, collection=bodies, which know the answers")
    for name, value, least in (
        ("quadruples", quadruples, 1), ("validation", validation, 1), ("bodies", bodies, 2), ("points", points, 1),
    ):  # fmt: skip
        check_whole(f"task.{name}", value, least)
    if seed == collection.seed:
        raise InputError(f"task.seed={seed}: expected another than collection.seed, whose bodies the net may know")
    trained = open_trained(pieces.ckpt_path, pieces.net, pieces.pipeline.cache, "analogy_benchmark", local)
    more = max(2, bodies // 2)
    asked = {"test": range(bodies), "validation": range(bodies, bodies + more)}
    rng = np.random.default_rng(seed)
    counts = {"test": quadruples, "validation": validation}
    drawn = {part: draw_quadruples(who, counts[part], rng) for part, who in asked.items()}

    others = Bodies(bodies + more, seed, collection.topology, collection.vary_age)
    shapes = Posed(others, [(body, pose) for body in range(len(others)) for pose in POSE_NAMES])
    operators = operators_of(trained, shapes, pieces.pipeline, neighbours)
    meshes = [shapes[i] for i in range(len(shapes))]
    truths = [sample(mesh, points, np.random.default_rng([0, i])) for i, mesh in enumerate(meshes)]
    rows: list[Row] = []
    for part, some in drawn.items():
        for name, answers in _answers(trained, operators, meshes, some).items():
            for quadruple, shape in zip(track(some, f"{part}, {name}"), answers, strict=True):
                told = {letter: shapes.names[int(getattr(quadruple, letter))] for letter in ("A", "B", "C", "truth")}
                scores = _compare(shape, meshes[quadruple.truth], truths[quadruple.truth])
                rows.append({"part": part, "role": quadruple.role, **told, "answer": name, **scores})
    write_rows(rows, out / "analogies.csv")
    _show(trained, operators, meshes, drawn["test"], out, collection.up)
    return _tell(rows, len(drawn["test"]))


@torch.no_grad()
def _answers(
    trained: Trained, operators: torch.Tensor, meshes: Sequence[Mesh], some: Sequence[Quadruple]
) -> dict[str, list[Shape]]:
    """Name of the answer → a shape a quadruple."""
    places = {letter: [getattr(q, letter) for q in some] for letter in ("A", "B", "C", "truth")}
    A, B, C, truth = (operators[i] for i in places.values())
    found = {"own": draw_points(trained.learner, truth)}
    found |= {method: answer(trained.learner, method, A, B, C) for method in METHODS}
    return {name: trained.to_shapes(drawn) for name, drawn in found.items()} | {"C": [meshes[i] for i in places["C"]]}


def _compare(shape: Shape, truth: Mesh, cloud: np.ndarray) -> dict[str, float]:
    seen = sample(shape, len(cloud), np.random.default_rng(SEED)) if isinstance(shape, Mesh) else shape.points
    cd = Indexed(seen).chamfer(Indexed(cloud))
    scores = {"cd": cd, "cd_over_level": cd / sampling_level(truth.area, len(seen), len(cloud))}
    if isinstance(shape, Mesh):
        scores["vertex_error_mm"] = 1000 * vertex_error(shape.vertices, truth.vertices)
    return scores


def _show(
    trained: Trained,
    operators: torch.Tensor,
    meshes: Sequence[Mesh],
    some: Sequence[Quadruple],
    out: Path,
    up: str | None,
) -> None:
    """The first few quadruples, a row each."""
    few = [q for q in some if q.role == "pose"][:SHOWN]
    answers = _answers(trained, operators, meshes, few)
    rows = {}
    for i, q in enumerate(few):
        given = {"A": meshes[q.A], "B": meshes[q.B], "C": meshes[q.C], "truth": meshes[q.truth]}
        rows[str(i + 1)] = given | {name: shapes[i] for name, shapes in answers.items() if name != "C"}
    sheet = shape_sheet(rows, up)
    sheet.savefig(out / "analogies.png")
    write_sheets(out / "tensorboard", {"analogies/sheet": sheet}, {}, up)


def _tell(rows: Sequence[Row], count: int) -> dict[str, float]:
    """The table in the log, and the metrics."""
    metrics: dict[str, float] = {}
    names = list(dict.fromkeys(row["answer"] for row in rows))
    for part in ("test", "validation"):
        for role in (None, *ROLES):
            some = [row for row in rows if row["part"] == part and role in (None, row["role"])]
            own = means([_numbers(row) for row in some if row["answer"] == "own"])
            for name in names:
                found = means([_numbers(row) for row in some if row["answer"] == name])
                found["over_own"] = found["cd"] / own["cd"]
                prefix = f"{part}/{name}" if role is None else f"{part}/{name}/{role}"
                metrics |= {f"{prefix}/{key}": value for key, value in found.items()}
    best = min(METHODS, key=lambda method: metrics[f"validation/{method}/cd"])
    log.info("%d analogies (the pose changes, the body changes), Chamfer distance to the truth:", count)
    log.info("  %-16s %10s %10s %10s %10s %10s", "", "CD", "pose", "body", "over own", "vertex mm")
    for name in names:
        cds = [metrics[f"test/{name}{role}/cd"] for role in ("", "/pose", "/body")]
        error = metrics.get(f"test/{name}/vertex_error_mm")
        cells = [*(f"{cd:10.6f}" for cd in cds), f"{metrics[f'test/{name}/over_own']:10.2f}"]
        log.info("  %-16s %s %10s", name, " ".join(cells), "" if error is None else f"{error:.1f}")
    log.info("best by validation: %s; analogies.csv, analogies.png", best)
    chosen = {key: metrics[f"test/{best}/{key}"] for key in ("cd", "cd_over_level", "over_own")}
    return {**{f"test/best/{key}": value for key, value in chosen.items()}, **metrics}


def _numbers(row: Mapping[str, str | float]) -> dict[str, float]:
    return {key: value for key, value in row.items() if isinstance(value, float)}
