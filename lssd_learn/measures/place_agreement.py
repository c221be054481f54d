"""`task=place_agreement`: do operators say where two groups differ as Procrustes analysis of landmarks does?

The answer of operators is, at each vertex, the difference of the mean logarithms of the local areas; that of landmarks
the logarithm of the area ratio under the thin-plate spline between the group means. Of generated shapes, whose vertices
correspond though the maps do not know it, the truth is there too, and which of the two is right.
"""

import logging
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import torch
from jaxtyping import Float, Int

from lssd_learn.collections.base import Collection
from lssd_learn.collections.groups import ChosenGroups, choose_groups
from lssd_learn.errors import InputError, check_whole
from lssd_learn.exploration.models.points import local_sizes
from lssd_learn.exploration.scores import correlation
from lssd_learn.exploration.template import landmark_means, template_log_ratio
from lssd_learn.latent import LatentSpace
from lssd_learn.maps.common_landmarks import common_landmarks
from lssd_learn.pieces import Pieces
from lssd_learn.shapes import Mesh
from lssd_learn.shapes.sampling import farthest_points
from lssd_learn.view.fields import Field
from lssd_learn.view.highlights import highlight_chart
from lssd_learn.written import write_rows

log = logging.getLogger(__name__)

TABLE = "places.csv"


def run(
    pieces: Pieces,
    out: Path,
    group: str | None = None,
    labels: Sequence[str] = (),
    landmarks: int = 51,
    shown: int = 2,
    azimuth: float = 20.0,
) -> dict[str, float]:
    """Write places.csv, a row a shape, and places.png: the answers on some shapes.

    Args:
        group, labels: see `choose_groups`; two groups.
        landmarks: of shapes whose vertices correspond and that have none, so many vertices spread over the first.
        shown: shapes in the picture.
        azimuth: degrees from which they are seen.

    Returns:
        Correlations over the surface, weighed by area, mean over the shapes: "landmarks", of the two answers, and
        "landmarks/smoothed", with the landmarks' as smooth as the functions of the latent space are; where the truth is
        known "truth/operators", "truth/landmarks" and both with /smoothed, where truth and landmarks are smoothed.

    Raises:
        InputError: not two groups of meshes; no landmarks in common; arguments out of range.
    """
    check_whole("task.landmarks", landmarks, 4)
    check_whole("task.shown", shown, 1)
    pipeline, collection = pieces.pipeline, pieces.pipeline.collection
    groups = choose_groups(collection, group, labels)
    if len(groups.labels) != 2 or None in groups.of:
        raise InputError(f"task.group: expected two groups, got {len(groups.labels)} (task.labels chooses)")
    shapes = [collection[int(i)] for i in groups.shapes]
    meshes = [shape for shape in shapes if isinstance(shape, Mesh)]
    if len(meshes) < len(shapes):
        raise InputError("task=place_agreement: expected meshes, got a cloud")
    points = _marks(collection, groups, landmarks)
    truth = _truth(collection, groups)
    latent, _ = pipeline.latent, pipeline.bases
    D = pipeline.operators(pieces.operators[:1])[groups.shapes, 0]
    sign = _signs(groups)
    means, kept = landmark_means(points, [str(label) for label in groups.of])
    first, second = (means[label] for label in groups.labels)
    rows: list[dict[str, Any]] = []
    seen: list[list[np.ndarray]] = []
    for j, (i, mesh) in enumerate(zip(groups.shapes.tolist(), meshes, strict=True)):
        mass, answers = pipeline.bases[i].mass, {"operators": sign @ local_sizes(latent, D, i)}
        answers["landmarks"] = template_log_ratio(mesh, points[j][kept], first, second)
        if truth is not None:
            answers["truth"], there = truth[j]
            mass = np.where(there, mass, 0.0)
        smooth = {name: smoothed(latent, field, i) for name, field in answers.items() if name != "operators"}
        row = {"name": collection.names[i], "label": groups.of[j]}
        pairs = [("landmarks", "operators"), *([("truth", "operators"), ("truth", "landmarks")] if truth else [])]
        for a, b in pairs:
            key = a if a == "landmarks" else f"{a}/{b}"
            row[key] = correlation(answers[a], answers[b], mass)
            row[f"{key}/smoothed"] = correlation(smooth[a], smooth.get(b, answers[b]), mass)
        rows.append(row)
        seen.append([100 * np.expm1(answers[name]) for name in ("operators", "landmarks", "truth") if name in answers])
    write_rows(rows, out / TABLE)
    metrics = {key: float(np.mean([row[key] for row in rows])) for key in rows[0] if key not in ("name", "label")}
    chosen = np.linspace(0, len(rows) - 1, min(shown, len(rows))).round().astype(int).tolist()
    names = ["operators", "landmarks and thin-plate spline", "truth"]
    areas = [meshes[j].vertex_areas for j in chosen]
    title = f"% of area, {groups.labels[1]} over {groups.labels[0]}"
    fields = [Field.signed(name, f"{name}: {title}", [seen[j][k] for j in chosen], areas)
              for k, name in enumerate(names[: len(seen[0])])]  # fmt: skip
    titles = [f"{groups.of[j]}\n{rows[j]['name']}" for j in chosen]
    highlight_chart([meshes[j] for j in chosen], titles, fields, collection.up, azimuth).savefig(out / "places.png")
    for key, value in metrics.items():
        log.info("  %-30s %6.3f", key, value)
    log.info("%s, places.png", TABLE)
    return {"shapes": len(rows), "landmarks/count": len(kept), **metrics}


def smoothed(latent: LatentSpace, field: Float[np.ndarray, " V"], i: int) -> Float[np.ndarray, " V"]:
    """(V,) the logarithm of an area ratio on shape i as an operator that has just this ratio would tell it.

    Args:
        latent: with its eigenbases.
        field: (V,) logarithms.
        i: the shape.
    """
    functions = latent.to_shape(torch.eye(latent.keep).to(latent.Y), i).cpu().numpy()
    phi, mass = functions / np.linalg.norm(functions, axis=1, keepdims=True), np.asarray(latent.eigenbasis(i).mass)
    changed, plain = (functions.T @ (weights[:, None] * functions) for weights in (mass * np.exp(field), mass))
    return np.log(((phi @ changed) * phi).sum(1) / ((phi @ plain) * phi).sum(1))


def _signs(groups: ChosenGroups) -> Float[np.ndarray, " n"]:
    """(n,) whose product with values of the shapes is the second group's mean less the first's."""
    second = np.array([label == groups.labels[1] for label in groups.of])
    return np.where(second, 1 / second.sum(), -1 / (~second).sum())


def _base(collection: Collection) -> Collection:
    """The shapes in vertex correspondence that others were made from."""
    while (made_of := getattr(collection, "base", None)) is not None:
        collection = made_of
    return collection


def _marks(collection: Collection, groups: ChosenGroups, count: int) -> Float[np.ndarray, "n m 3"]:
    """(n, m, 3) the landmarks that all have; or vertices spread over the first shape, where vertices correspond."""
    if len(collection.landmarks):
        vertices = common_landmarks(collection)
        return np.stack([collection[int(i)].vertices[vertices[i]] for i in groups.shapes])
    shapes = [collection[int(i)] for i in groups.shapes]
    if len({shape.connectivity for shape in shapes}) > 1 or shapes[0].connectivity is None:
        raise InputError("task=place_agreement: expected landmarks, or shapes whose vertices correspond")
    at = farthest_points(shapes[0].vertices, count)
    return np.stack([shape.vertices[at] for shape in shapes])


def _truth(collection: Collection, groups: ChosenGroups) -> list[tuple[np.ndarray, np.ndarray]] | None:
    """Of each shape (V,) the true log area ratio of the groups, and where there is one; None where it is not known."""
    base = _base(collection)
    shapes = [base[int(i)] for i in groups.shapes]
    if len({shape.connectivity for shape in shapes}) > 1 or not isinstance(shapes[0], Mesh):
        return None
    ratio = _signs(groups) @ np.log([shape.vertex_areas for shape in shapes if isinstance(shape, Mesh)])
    found = []
    for i in groups.shapes.tolist():
        origins = _origins(collection, i, len(ratio))
        found.append((ratio[origins], origins >= 0))
    return found


def _origins(collection: Any, i: int, vertices: int) -> Int[np.ndarray, " V"]:
    """(V,) for each vertex of shape i the vertex of `_base` it stands beside, -1 where there is none."""
    if getattr(collection, "base", None) is None:
        return np.arange(vertices)
    own, below = collection.origins(i), _origins(collection.base, i, vertices)
    return np.where(own >= 0, below[own], -1)
