"""`task=analogy`: the shape that is to C what B is to A, by algebra on operators, drawn by a trained reconstruction."""

import logging
from collections.abc import Sequence
from pathlib import Path
from typing import cast

import numpy as np
import torch
from torch import Tensor

from lssd_learn.collections.chosen import Chosen
from lssd_learn.collections.generated.bodies import Bodies
from lssd_learn.collections.generated.posed import Made, Posed
from lssd_learn.collections.regions import region_mask
from lssd_learn.errors import check_whole
from lssd_learn.latent import LatentSpace
from lssd_learn.learning import Learner
from lssd_learn.learning.scores.reconstructed import SEED
from lssd_learn.learning.scores.reconstruction_scores import TrueSurface, vertex_error
from lssd_learn.models.synthesis import (
    METHODS,
    answer,
    channelwise,
    choose,
    draw_points,
    open_trained,
    operators_of,
    result,
    suited,
)
from lssd_learn.nets import KernelMachine
from lssd_learn.operators import localise
from lssd_learn.pieces import Pieces
from lssd_learn.shapes import Mesh, Shape, sample
from lssd_learn.view.exports import export
from lssd_learn.view.sheets import shape_sheet, write_sheets

log = logging.getLogger(__name__)

# Which of `METHODS` a partial analogy takes its other half from: the paper's.
WHOLE = "multiplicative"


@torch.no_grad()
def run(
    pieces: Pieces,
    out: Path,
    a: str,
    b: str,
    c: str,
    region: str | Sequence[int] | None = None,
    threshold: float = 0.5,
    points: int = 4096,
    neighbours: int = 5,
    local: bool = True,
) -> dict[str, float]:
    """Write analogy.png and shapes/: A, B, C, what the net makes of their operators, the answers of `METHODS`.

    Args:
        a, b, c: names of shapes of the collection; of generated bodies also with a pose, as body_0003:sitting.
        region: see `region_mask`; then there are partial analogies too: P1 is B on the region and A elsewhere, P2 the
            multiplicative answer on the region and C elsewhere.
        threshold: part of a function that must lie on the region for it to count as the region's.
        points: that shapes are compared by.
        neighbours: training shapes that a new one is pushed from.
        local: see `open_trained`.

    Returns:
        "answers", how many; where the collection can make the true answer, <method>/ and own/ (what the net makes of
        the operators of the truth) with the numbers of `CloudScores`, and vertex_error_mm of meshes.

    Raises:
        InputError: see `open_trained`, `choose`, `operators_of`, `region_mask`.
    """
    check_whole("task.points", points, 1)
    collection = pieces.pipeline.collection
    trained = open_trained(pieces.ckpt_path, pieces.net, pieces.pipeline.cache, "analogy", local)
    chosen = choose(collection, {"task.a": a, "task.b": b, "task.c": c})
    truth = _truth(chosen)
    picks = chosen if truth is None else Chosen([*chosen.picks, truth])
    shapes = list(picks)
    mask = None if region is None else region_mask(region, collection, len(shapes[0].vertices))
    learner, operators = trained.learner, operators_of(trained, picks, pieces.pipeline, neighbours)
    A, B, C = (operators[i : i + 1] for i in range(3))

    drawn = trained.to_shapes(draw_points(learner, operators))
    answers = {m: trained.to_shapes(answer(learner, m, A, B, C))[0] for m in METHODS}
    given: dict[str, Shape] = dict(zip(("A", "B", "C", "truth"), shapes, strict=False))
    again = {f"{name} drawn": shape for name, shape in zip(given, drawn, strict=True)}
    rows: dict[str, dict[str, Shape]] = {"shapes": given, "by the net": again, "answers": answers}
    if mask is not None:
        F = cast(LatentSpace, trained.latent).region(mask, threshold)
        log.info("region of %d vertices, %d of %d functions", mask.sum(), F.shape[1], F.shape[0])
        halves = {"P1": (A, B), "P2": (C, result(WHOLE, A, B, C))}
        parts = {name: trained.to_shapes(_mixed(learner, F, *pair))[0] for name, pair in halves.items()}
        rows["on the region"] = parts

    sheet = shape_sheet(rows, collection.up)
    sheet.savefig(out / "analogy.png")
    scenes = {"analogy/shapes": list(given.values()), "analogy/answers": list(answers.values())}
    write_sheets(out / "tensorboard", {"analogy/sheet": sheet}, scenes, collection.up)
    for row in rows.values():
        for title, shape in row.items():
            export(shape, out / "shapes", title, collection.up)
    scores = {} if truth is None else _score(cast(Mesh, shapes[3]), {**answers, "own": drawn[3]}, points)
    log.info("%s is to %s as %s is to the answers in analogy.png; PLY and GLB of all: shapes/", *chosen.names)
    return {"answers": len(answers), **scores}


def _mixed(learner: Learner, F: Tensor, outside: Tensor, inside: Tensor) -> Tensor:
    """What the net draws of operators (1, channels, m, m) that are one on the region F and another elsewhere."""
    if not isinstance(learner.net, KernelMachine):
        return draw_points(learner, channelwise(lambda D, E: localise(D, E, F), outside, inside))
    outside, inside = suited(learner, outside), suited(learner, inside)
    return draw_points(learner, channelwise(lambda D, E: localise(D, E, F, symmetric=True), outside, inside))


def _truth(chosen: Chosen) -> tuple[Made, int] | None:
    """The body with the parameters of C plus B less A, in B's pose if A stands as C does and in C's if it stands as B
    does; nothing where the parameters leave their range or the poses do not say."""
    known = [body for pick in chosen.picks if (body := _body(*pick)) is not None]
    if len(known) < len(chosen.picks):
        return None
    (bodies, a, pose_a), (_, b, pose_b), (_, c, pose_c) = known
    parameters = c + b - a
    if pose_a not in (pose_b, pose_c) or (np.abs(parameters - 0.5) > 0.5 + 1e-9).any():
        log.info("no truth: A stands neither as B nor as C does, or the parameters add up to no body")
        return None
    return Made(bodies, np.clip(parameters, 0, 1), pose_b if pose_a == pose_c else pose_c, "truth"), 0


def _body(collection, i: int) -> tuple[Bodies, np.ndarray, str] | None:
    """The collection, parameters and pose of a generated body."""
    if isinstance(collection, Posed):
        body, pose = collection.pairs[i]
        return collection.bodies, collection.bodies.sliders[body], pose
    if isinstance(collection, Bodies) and "pose" in collection.groups and not collection.jitter:
        return collection, collection.sliders[i], str(collection.groups["pose"][i])
    return None


def _score(truth: Mesh, answers: dict[str, Shape], points: int) -> dict[str, float]:
    surface = TrueSurface(truth, sample(truth, points, np.random.default_rng([0, 0])))
    metrics: dict[str, float] = {}
    log.info("  %-16s %10s %10s", "", "CD", "vertex mm")
    for name, shape in answers.items():
        found = dict(vars(surface.score(shape, SEED)))
        if isinstance(shape, Mesh):
            found["vertex_error_mm"] = 1000 * vertex_error(shape.vertices, truth.vertices)
        log.info("  %-16s %10.6f %10s", name, found["cd"], f"{found.get('vertex_error_mm', np.nan):.1f}")
        metrics |= {f"{name}/{key}": value for key, value in found.items()}
    return metrics
