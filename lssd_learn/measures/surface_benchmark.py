"""`task=surface_benchmark`: how far computed surfaces are from bodies that are made with the same parameters.

The surfaces are those of a linear model with all parameters of the bodies, see `exploration/surfaces`, along some of
these, and two standard deviations along principal components of the operators.
"""

import logging
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float

from lssd_learn.collections import Bodies, Characters, Remeshed
from lssd_learn.errors import InputError
from lssd_learn.exploration.models.known import ask
from lssd_learn.exploration.models.strata import strata
from lssd_learn.exploration.models.vectors import model_vectors
from lssd_learn.exploration.representatives import representatives
from lssd_learn.exploration.surfaces.found import score_surfaces
from lssd_learn.exploration.surfaces.morphs import FAR
from lssd_learn.pieces import Pieces
from lssd_learn.shapes import Mesh, Shape
from lssd_learn.shapes.kabsch import kabsch
from lssd_learn.view.sheets import shape_sheet
from lssd_learn.written import write_rows

log = logging.getLogger(__name__)

TABLE = "surfaces.csv"
MILLIMETRES = 1000  # of the metres that bodies are in


def run(
    pieces: Pieces,
    out: Path,
    parameters: Sequence[str] = ("muscle", "weight", "height", "waist"),
    azimuth: float = 20.0,
) -> dict[str, float]:
    """Write surfaces.csv and surfaces.png: a row a surface, its mean distance from the body there is, vertex by vertex.

    Along a parameter from two standard deviations below its mean to two above, as far as bodies can be made; the
    other parameters are at their mean. What belongs to a place along a component is the linear regression of all
    parameters on it, and again as far as bodies can be made; where they stand in several poses, components are left
    out. Bodies are laid on each other by a rigid motion first.

    Args:
        parameters: along which.
        azimuth: degrees from which bodies are seen in the picture.

    Returns:
        In millimetres mean, and worst, the largest mean of a surface, along parameters and along components; unmoved,
        the mean distance of the shape that lends its mesh, for comparison.

    Raises:
        InputError: no collection of bodies, or an unknown parameter.
    """
    pipeline, collection = pieces.pipeline, pieces.pipeline.collection
    base = collection.base if isinstance(collection, Remeshed) else collection
    if not isinstance(base, Bodies | Characters):
        raise InputError("task=surface_benchmark: expected bodies or characters, or these remeshed")
    if unknown := [name for name in parameters if name not in base.parameter_names]:
        raise InputError(f"task.parameters: expected some of {', '.join(base.parameter_names)}, got {unknown[0]!r}")
    poses = [str(pose) for pose in base.groups["pose"]]
    formula = " + ".join([*base.parameter_names, *["pose"] * (len(set(poses)) > 1)])
    asked = ask(collection, f"~ {formula}")
    parts = strata(asked.design, None, permutations=1)
    _ = pipeline.latent, pipeline.bases  # whoever asks for the operators gets missing eigenbases made too
    operators = pipeline.operators(pieces.operators)
    vectors = model_vectors(operators, pieces.operators) if len(set(poses)) == 1 else {}
    scores = {f"{kind} PC{c + 1}": Y[:, c] for kind, Y in vectors.items() for c in (0, 1)}
    shown = representatives(operators)[0]
    shape, workers = collection[shown], pipeline.workers
    found = score_surfaces(pipeline.whole, asked.shapes, scores, shown, shape, workers=workers)
    found = found.with_model(asked, parts, shown)

    theta = np.asarray(base.parameters)
    mean, lender, rows, seen = theta.mean(0), found.lender, [], {}
    for morph in found.morphs:
        if morph.title in parameters and morph.at is not None:
            j, (low, high) = list(base.parameter_names).index(morph.title), morph.at
            row = {}
            for value in (max(0.0, low), float(mean[j]), min(1.0, high)):
                s = (value - mean[j]) / ((high - low) / 2)
                goal = _body(base, collection, shown, np.where(np.arange(len(mean)) == j, value, mean), poses[shown])
                rows.append(_row(morph.title, value, lender.vertices(morph.x(s)), goal, lender.shape))
                row |= {f"{value:.2f}": lender.surface(morph.x(s)), f"{value:.2f}, true": _like(lender.shape, goal)}
            seen[morph.title] = row
    for name, morph in found.components.items():
        about = scores[name] - scores[name].mean()
        slope = about @ (theta - mean) / (about @ about) * FAR * about.std(ddof=1)
        for side in (-1, 1):
            # As far as all parameters can go: a uniform one ends before two standard deviations.
            room = np.where(side * slope > 0, 1 - mean, mean) / np.maximum(np.abs(slope), np.finfo(float).tiny)
            s = side * min(1.0, float(room.min()))
            goal = _body(base, collection, shown, np.clip(mean + s * slope, 0, 1), poses[shown])
            rows.append(_row(name, s * FAR, lender.vertices(morph.x(s)), goal, lender.shape))
    write_rows(rows, out / TABLE)
    shape_sheet(seen, collection.up, azimuth, size=220).savefig(out / "surfaces.png")
    metrics = {}
    for what, some in (("parameters", parameters), ("components", list(scores))):
        errors = [row["mm"] for row in rows if row["along"] in some]
        if errors:
            metrics |= {f"{what}/mean": float(np.mean(errors)), f"{what}/worst": float(np.max(errors))}
            metrics[f"{what}/unmoved"] = float(np.mean([row["mm unmoved"] for row in rows if row["along"] in some]))
    for row in rows:
        log.info("%-12s at %6.2f: %5.1f mm, unmoved %6.1f mm", *row.values())
    return metrics


def _body(
    base: Bodies | Characters, collection: Any, shown: int, theta: Float[np.ndarray, " p"], pose: str
) -> Float[np.ndarray, "V 3"]:
    """(V, 3) where the vertices of a shape of the collection are on the body with these parameters."""
    body = base.make(theta.tolist(), pose).vertices
    if not isinstance(collection, Remeshed):
        return body
    origins = collection.origins(shown)  # its own vertices lie beside these
    return body[origins] + collection[shown].vertices - base[shown].vertices[origins]


def _row(along: str, value: float, points: np.ndarray, goal: np.ndarray, shape: Shape) -> dict[str, Any]:
    return {"along": along, "value": value, "mm": _off(points, goal), "mm unmoved": _off(shape.points, goal)}


def _off(points: Float[np.ndarray, "V 3"], goal: Float[np.ndarray, "V 3"]) -> float:
    """Mean distance in millimetres, the one laid on the other."""
    a, b = points - points.mean(0), goal - goal.mean(0)
    return MILLIMETRES * float(np.linalg.norm(a @ kabsch(a, b) - b, axis=1).mean())


def _like(shape: Shape, points: np.ndarray) -> Shape:
    return Mesh(points, shape.faces) if isinstance(shape, Mesh) else type(shape)(points)
