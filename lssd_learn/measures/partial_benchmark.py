"""`task=partial_benchmark`: how far partial analogies come from their known answers.

The upper body of B on the lower body of A, or the other way round, as `mixtures.py` makes them: of bodies of another
seed, pushed into the latent space of the checkpoint.
"""

import logging
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import cast

import numpy as np
import torch
from torch import Tensor

from lssd_learn.collections.chosen import Chosen
from lssd_learn.collections.generated.bodies import Bodies
from lssd_learn.collections.generated.mixed import named_pose
from lssd_learn.errors import InputError, check_whole
from lssd_learn.latent.region import Region, find_region
from lssd_learn.learning.scores.reconstructed import SEED, means
from lssd_learn.learning.scores.reconstruction_scores import vertex_error
from lssd_learn.measures.mixtures import ROLES, SLIDERS, Mixture, draw_mixtures
from lssd_learn.models.synthesis import channelwise, draw_points, open_trained, operators_of
from lssd_learn.models.trained import Trained
from lssd_learn.operators import blend, localise
from lssd_learn.pieces import Pieces
from lssd_learn.progress import track
from lssd_learn.shapes import Mesh, Shape, sample
from lssd_learn.shapes.nearest import Indexed
from lssd_learn.view.exports import export
from lssd_learn.view.sheets import shape_sheet, write_sheets
from lssd_learn.written import write_rows

log = logging.getLogger(__name__)

HALF = 0.5  # the threshold by which a region and the rest share the functions alike
POSES = ("known_pose", "new_pose")
SHOWN = 2  # partial analogies of each role in the picture
Row = dict[str, str | float]


def run(
    pieces: Pieces,
    out: Path,
    pairs: int = 40,
    validation: int = 20,
    bodies: int = 8,
    seed: int = 1,
    region: str = "upper_body",
    thresholds: Sequence[float] = (0.05, 0.2, 0.5, 0.8, 0.95),
    points: int = 4096,
    neighbours: int = 5,
    local: bool = True,
) -> dict[str, float]:
    """Write partial.csv, partial.png and the shapes in it; print the table.

    Args:
        pairs, validation: of A and B for each of the three roles, in which B differs from A: the body, the pose, both.
            By those of validation, of other bodies, the best method is chosen.
        bodies: that the pairs of the test are drawn from; half as many more, two at least, are those of validation.
        seed: of their parameters; another than the collection's.
        region: upper_body or lower_body, where the truth is like B.
        thresholds: part of a function that must lie on the region for it to count as the region's, see `region.region`:
            those at its border, where legs begin, may matter more to one side than to the other.
        points: of the true clouds, and of meshes that are compared with them.
        neighbours: training shapes that each new one is pushed from.
        local: see `open_trained`.

    Returns:
        test/<answer>/ and validation/<answer>/ with cd, cd_inside and cd_outside the region, over_own (cd over that of
        drawing the truth from its own operator), of meshes also vertex_error_mm, and the same _inside and _outside. The
        answers are plain, the paper's formula, and log_euclidean, see `blend`; symmetric_<threshold>, see `localise`;
        "own", what is drawn from the operator of the truth; "A" and "B", the trivial answers. The same by role, as
        test/plain/pose/cd, and by whether the collection has the pose of the truth, as test/plain/new_pose/cd.
        test/best/ is the answer with the least cd on validation, chosen_threshold its own, 0.5 if not symmetric.

    Raises:
        InputError: a collection that is not of generated bodies, arguments out of range; see `open_trained`.
    """
    collection = pieces.pipeline.collection
    known = getattr(collection, "bodies", collection)
    if not isinstance(known, Bodies) or "pose" not in collection.groups:
        raise InputError(
            "task=partial_benchmark: expected generated bodies, collection=bodies or mixed, which know the answers"
        )
    for name, value, least in (("pairs", pairs, 1), ("validation", validation, 1), ("bodies", bodies, 2),
                               ("points", points, 1)):  # fmt: skip
        check_whole(f"task.{name}", value, least)
    if region not in SLIDERS:
        raise InputError(f"task.region={region}: expected one of {', '.join(SLIDERS)}, of which the answer is known")
    if seed == known.seed:
        raise InputError(f"task.seed={seed}: expected another than collection.seed, whose bodies the net may know")
    for threshold in thresholds:
        if not 0 <= threshold < 1:
            raise InputError(f"task.thresholds: expected parts of 1, 0 or more and below 1, got {threshold}")
    trained = open_trained(pieces.ckpt_path, pieces.net, pieces.pipeline.cache, "partial_benchmark", local)
    more, rng = max(2, bodies // 2), np.random.default_rng(seed)
    drawn = {"test": draw_mixtures(range(bodies), pairs, rng)}
    drawn["validation"] = draw_mixtures(range(bodies, bodies + more), validation, rng)

    others = Bodies(bodies + more, seed, known.topology, known.vary_age)
    asked = [mixture for some in drawn.values() for mixture in some]
    shapes = Chosen([(made, 0) for mixture in asked for made in mixture.shapes(others, region)])
    operators = operators_of(trained, shapes, pieces.pipeline, neighbours)
    mask = np.asarray(known.parts[region])
    answers = _answers(trained, operators, find_region(trained.latent, mask, HALF), thresholds)
    methods = [name for name in answers if name != "own"]
    meshes = [cast(Mesh, shape) for shape in shapes]
    answers |= {"A": meshes[0::3], "B": meshes[1::3]}
    parts = [part for part, some in drawn.items() for _ in some]
    poses = [named_pose(str(label)) for label in np.unique(collection.groups["pose"])]
    rows: list[Row] = []
    for i, mixture in enumerate(track(asked, "scoring")):
        truth = _Truth(meshes[3 * i + 2], mask, points, i)
        told = {"part": parts[i], "role": mixture.role, "p": mixture.p, "q": mixture.q, "a": mixture.a, "b": mixture.b}
        told["pose"] = POSES[mixture.pose(region) not in poses]
        rows += [{**told, "answer": name, **truth.score(given[i])} for name, given in answers.items()]
    write_rows(rows, out / "partial.csv")
    metrics = _means(rows)
    best = min(methods, key=lambda method: metrics[f"validation/{method}/cd"])
    again = _drawn(trained, operators[: 3 * len(drawn["test"])])
    _show(drawn["test"], meshes, again, answers, best, out, collection.up)
    log.info("%d pairs, B on the %s and A elsewhere", len(drawn["test"]), region.replace("_", " "))
    _tell(metrics, list(answers))
    log.info("best by validation: %s; partial.csv, partial.png, PLY and GLB of the shapes in it: shapes/", best)
    chosen = ("cd", "cd_inside", "cd_outside", "over_own")
    threshold = float(best.rpartition("_")[2]) if best.startswith("symmetric_") else HALF
    found = {f"test/best/{key}": metrics[f"test/{best}/{key}"] for key in chosen}
    return {**found, "chosen_threshold": threshold, **metrics}


def _answers(
    trained: Trained, operators: Tensor, region: Region, thresholds: Sequence[float]
) -> dict[str, list[Shape]]:
    """Name of the answer → a shape for every A, B and truth in turn."""
    A, B, truth = (operators[i::3] for i in range(3))
    shares, V = torch.linalg.eigh(region.operator)
    found = {
        "own": truth,
        "plain": channelwise(lambda X, Y: localise(X, Y, region.functions), A, B),
        "log_euclidean": channelwise(lambda X, Y: blend(X, Y, region.operator), A, B),
    }
    for threshold in thresholds:
        F = V[:, shares > threshold]
        log.info("region at %g: %d of %d functions", threshold, F.shape[1], F.shape[0])
        found[f"symmetric_{threshold:g}"] = channelwise(lambda X, Y, F=F: localise(X, Y, F, symmetric=True), A, B)
    return {name: _drawn(trained, D) for name, D in found.items()}


@torch.no_grad()
def _drawn(trained: Trained, operators: Tensor) -> list[Shape]:
    return trained.to_shapes(draw_points(trained.learner, operators))


class _Truth:
    """One answer that is known, inside and outside the region `mask` (V,) of its vertices; `number` draws its cloud."""

    def __init__(self, mesh: Mesh, mask: np.ndarray, points: int, number: int):
        self.mesh, self.mask = mesh, mask
        self.cloud = sample(mesh, points, np.random.default_rng([0, number]))
        self.indexed = Indexed(self.cloud)
        self.inside = mask[Indexed(mesh.vertices).nearest(self.cloud)[1]]

    def score(self, shape: Shape) -> dict[str, float]:
        """Chamfer distance, and the same of the true points of one side and those of the answer nearest to them."""
        seen = sample(shape, len(self.cloud), np.random.default_rng(SEED)) if isinstance(shape, Mesh) else shape.points
        there, nearest = self.indexed.nearest(seen)
        back = Indexed(seen).distances(self.cloud)
        scores = {"cd": float(np.mean(there**2) + np.mean(back**2))}
        for side, where in (("inside", self.inside), ("outside", ~self.inside)):
            mine = there[where[nearest]]  # none, where the answer has nothing near this side
            scores[f"cd_{side}"] = float((np.mean(mine**2) if len(mine) else 0) + np.mean(back[where] ** 2))
        if isinstance(shape, Mesh):
            scores["vertex_error_mm"] = 1000 * vertex_error(shape.vertices, self.mesh.vertices)
            for side, where in (("inside", self.mask), ("outside", ~self.mask)):
                error = vertex_error(shape.vertices[where], self.mesh.vertices[where])
                scores[f"vertex_error_mm_{side}"] = 1000 * error
        return scores


def _show(
    some: Sequence[Mixture],
    meshes: Sequence[Mesh],
    again: Sequence[Shape],
    answers: Mapping[str, Sequence[Shape]],
    best: str,
    out: Path,
    up: str | None,
) -> None:
    """The first pairs of each role, a row each: what is given, the best answer, the truth; drawn is by the net."""
    rows = {}
    for role in ROLES:
        for i in [i for i, mixture in enumerate(some) if mixture.role == role][:SHOWN]:
            A, B, truth = (3 * i + j for j in range(3))
            row = {"A": meshes[A], "B": meshes[B], "A drawn": again[A], "B drawn": again[B]}
            row |= {best.replace("_", " "): answers[best][i], "truth drawn": answers["own"][i], "truth": meshes[truth]}
            rows[title := f"{role} {len(rows) + 1}"] = row
            for name, shape in row.items():
                export(shape, out / "shapes", f"{title} {name}", up)
    sheet = shape_sheet(rows, up)
    sheet.savefig(out / "partial.png")
    write_sheets(out / "tensorboard", {"partial/sheet": sheet}, {}, up)


def _means(rows: Sequence[Row]) -> dict[str, float]:
    """part/answer/group/score: of all rows, of each role, of known and of new poses."""
    groups = {"": rows}
    groups |= {f"/{role}": [row for row in rows if row["role"] == role] for role in ROLES}
    groups |= {f"/{pose}": [row for row in rows if row["pose"] == pose] for pose in POSES}
    metrics: dict[str, float] = {}
    for part in ("test", "validation"):
        for group, all_rows in groups.items():
            some = [row for row in all_rows if row["part"] == part]
            for name in dict.fromkeys(row["answer"] for row in some):
                found = means([_numbers(row) for row in some if row["answer"] == name])
                found["over_own"] = found["cd"] / metrics.get(f"{part}/own{group}/cd", found["cd"])
                metrics |= {f"{part}/{name}{group}/{key}": value for key, value in found.items()}
    return metrics


def _tell(metrics: Mapping[str, float], answers: Sequence[str]) -> None:
    """The table in the log."""
    score, scale, unit = "vertex_error_mm", 1, "mean vertex error in mm"
    if f"test/own/{score}" not in metrics:
        score, scale, unit = "cd", 1e4, "Chamfer distance in cm²"
    groups = [group for group in (*ROLES, *POSES) if f"test/own/{group}/cd" in metrics]
    log.info("%s, of all, on the region, elsewhere, by what B differs from A in, by the pose of the truth", unit)
    log.info("over own: Chamfer distance over that of what is drawn from the truth's own operator")
    heads = ["over own", "all", "region", "else", *(group.replace("_", " ") for group in groups)]
    log.info("  %-16s %s", "", " ".join(f"{head:>10}" for head in heads))
    for name in answers:
        keys = [f"{score}", f"{score}_inside", f"{score}_outside", *(f"{group}/{score}" for group in groups)]
        cells = [f"{metrics[f'test/{name}/over_own']:10.2f}"]
        cells += [f"{scale * metrics[f'test/{name}/{key}']:10.2f}" for key in keys]
        log.info("  %-16s %s", name, " ".join(cells))


def _numbers(row: Mapping[str, str | float]) -> dict[str, float]:
    return {key: value for key, value in row.items() if isinstance(value, float)}
