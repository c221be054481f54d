"""How good reconstructions are: each answer beside the true surface, and which pose it is taken for."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np
from jaxtyping import Float

from lssd_learn.collections.base import Collection
from lssd_learn.learning.scores.reconstruction_scores import TrueSurface, vertex_error
from lssd_learn.progress import track
from lssd_learn.shapes import Mesh, Shape, sample
from lssd_learn.shapes.nearest import Indexed
from lssd_learn.written import write_rows

# Of the points a mesh is scored by: the true clouds come from (0, position), the samples of a true surface from 0.
SEED = 1
POINTS = 512  # that tell poses apart: their spacing is a few centimetres, a limb moves by tens

Answer = Callable[[int], Shape]  # of a position in the collection


class NearestPose:
    """The pose of the training shape with the least Chamfer distance, on a few hundred points of each.

    Args:
        clouds: (n, N, 3) area-uniform samples of the training shapes.
        poses: n labels.
    """

    def __init__(self, clouds: Float[np.ndarray, "n N 3"], poses: Sequence[str] | np.ndarray):
        self.poses = list(poses)
        self.clouds = [Indexed(cloud[:POINTS]) for cloud in clouds]  # samples are in no order: the first are any

    def __call__(self, shape: Shape) -> str:
        points = Indexed(sample(shape, POINTS, np.random.default_rng(SEED)))
        return self.poses[int(np.argmin([points.chamfer(cloud) for cloud in self.clouds]))]


def score_answers(
    answers: Mapping[str, Answer],
    collection: Collection,
    positions: np.ndarray,
    clouds: np.ndarray,
    poses: tuple[NearestPose, Sequence[str] | np.ndarray] | None,
) -> dict[str, list[dict[str, float]]]:
    """Score every answer on every shape.

    Args:
        answers: name → a shape for each of the positions.
        collection: the truth, meshes.
        positions: of the shapes that are asked about.
        clouds: (n, N, 3) true points of the whole collection.
        poses: what tells a pose, and the true one of every shape of the collection; None where nobody knows.

    Returns:
        Name → a row a position: those of `CloudScores`; vertex_error_mm where the answer has the faces of the truth;
        pose_agreement, 1 or 0.
    """
    rows: dict[str, list[dict[str, float]]] = {name: [] for name in answers}
    for i in track(positions.tolist(), "scoring"):
        truth = collection[i]
        surface = TrueSurface(truth, clouds[i])
        for name, answer in answers.items():
            shape = answer(i)
            row = dict(vars(surface.score(shape, SEED)))
            if isinstance(shape, Mesh) and shape.connectivity == truth.connectivity:
                row["vertex_error_mm"] = 1000 * vertex_error(shape.vertices, truth.vertices)
            if poses is not None:
                row["pose_agreement"] = float(poses[0](shape) == poses[1][i])
            rows[name].append(row)
    return rows


def means(rows: Sequence[Mapping[str, float]]) -> dict[str, float]:
    """The mean of every column that all rows have."""
    return {key: float(np.mean([row[key] for row in rows])) for key in rows[0] if all(key in row for row in rows)}


def write_scores(rows: Mapping[str, Sequence[Mapping[str, float]]], names: Sequence[str], path: Path) -> None:
    """A line a shape and answer; what is not there stays empty."""
    write_rows(
        (
            {"name": name, "answer": answer, **row}
            for answer, scores in rows.items()
            for name, row in zip(names, scores, strict=True)
        ),
        path,
    )
