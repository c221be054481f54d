"""`task=landmark_stability`: does a comparison show the same with fewer landmarks, and what do landmarks show alone?

Maps are computed from a few landmarks, from more, and the groups compared with each. Beside them stands the answer of
landmarks alone: group means after Procrustes analysis, and the thin-plate spline between them (`template.py`).
"""

import inspect
import logging
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np
from torch.utils.tensorboard import SummaryWriter

from lssd_learn.collections.groups import ChosenGroups, choose_groups
from lssd_learn.errors import InputError, check_whole
from lssd_learn.exploration import (
    cross_collection,
    evidence,
    held_out_accuracy,
    local_evidence,
    permutation_test,
    representatives,
)
from lssd_learn.exploration.scores import correlation
from lssd_learn.exploration.template import landmark_means, template_log_ratio
from lssd_learn.maps.common_landmarks import common_landmarks
from lssd_learn.pieces import Pieces
from lssd_learn.pipeline import Pipeline
from lssd_learn.shapes import Mesh
from lssd_learn.view.coloured import add_picture, save_coloured
from lssd_learn.view.fields import Field
from lssd_learn.view.highlights import highlight_chart

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class _Found:
    """What one number of landmarks shows: (V,) a shape, the region and the square of the best function; numbers."""

    region: list[np.ndarray]
    function: list[np.ndarray]
    p_value: float
    accuracy: float


def run(
    pieces: Pieces,
    out: Path,
    landmarks: Sequence[int] = (6, 12, 24),
    group: str | None = None,
    labels: Sequence[str] = (),
    permutations: int = 999,
    shown: int = 2,
    azimuth: float = 20.0,
) -> dict[str, float]:
    """Write highlighted.png and coloured shapes: a row each number of landmarks, and the landmarks' own answer.

    Args:
        landmarks: how many, two numbers or more, ascending.
        group, labels: see `choose_groups`.
        permutations: of `permutation_test`.
        shown: shapes that stand for each group.
        azimuth: degrees from which they are seen.

    Returns:
        Of the first kind of operator, for each number n: n/region and n/function, the correlation of the squared field
        and of the square of the best function with those of most landmarks, over the surface, mean over the shapes;
        n/p_value, n/accuracy (held out); and of two groups of meshes n/template, the correlation of the region with
        the landmarks' own answer from all landmarks.

    Raises:
        InputError: maps that take no landmarks; as `choose_groups` and `common_landmarks`.
    """
    pipeline = pieces.pipeline
    counts = list(landmarks)
    if len(counts) < 2 or counts != sorted(set(counts)):
        raise InputError(f"task.landmarks={counts}: expected two numbers or more, ascending")
    check_whole("task.shown", shown, 1)
    check_whole("task.permutations", permutations, 1)
    if "landmarks" not in inspect.signature(pipeline.maps).parameters:
        raise InputError("maps: expected maps that are computed from landmarks, maps=spline, adjoint or landmarks")
    groups = choose_groups(pipeline.collection, group, labels)
    common_landmarks(pipeline.collection, counts[-1])  # whether there are so many, before the long work
    found = {n: _compare(pieces, n, groups, permutations) for n in counts}
    chosen = _representatives(pipeline, pieces, groups, counts[-1], shown)

    most, metrics = found[counts[-1]], {}
    template, masses = _template(pipeline, groups), [pipeline.bases[i].mass for i in groups.shapes]
    for n, one in found.items():
        metrics |= {f"{n}/region": _agreement(one.region, most.region, masses)}
        metrics |= {f"{n}/function": _agreement(one.function, most.function, masses)}
        metrics |= {f"{n}/p_value": one.p_value, f"{n}/accuracy": one.accuracy}
        if template is not None:
            metrics |= {f"{n}/template": _agreement(one.region, [t**2 for t in template], masses)}

    def some(fields: Sequence[np.ndarray]) -> list[np.ndarray]:
        return [fields[list(groups.shapes).index(i)] for i in chosen]

    kind = pieces.operators[0]
    fields = [Field.positive(f"landmarks_{n}", f"{kind}, maps from {n} landmarks", _roots(some(one.region)))
              for n, one in found.items()]  # fmt: skip
    if template is not None:
        title = "all landmarks, Procrustes analysis and thin-plate spline: |log area ratio|"
        fields.append(Field.positive("template", title, [np.abs(t) for t in some(template)]))
    _show(pipeline, groups, chosen, fields, out, azimuth)
    _tell(metrics, counts, len(groups.shapes))
    return {"shapes": len(groups.shapes), **metrics}


def _compare(pieces: Pieces, count: int, groups: ChosenGroups, permutations: int) -> _Found:
    pipeline = _with_landmarks(pieces.pipeline, count)
    latent, _ = pipeline.latent, pipeline.bases
    D = pipeline.operators(pieces.operators[:1])[groups.shapes, 0]
    R, alpha = evidence(D, groups.of), cross_collection(D, groups.of)
    return _Found(
        region=[local_evidence(latent, R, i).square().cpu().numpy() for i in groups.shapes],
        function=[latent.to_shape(alpha, i).square().cpu().numpy() for i in groups.shapes],
        p_value=permutation_test(D, groups.of, permutations, pieces.seed).p_value,
        accuracy=held_out_accuracy(D, groups.of),
    )


def _with_landmarks(pipeline: Pipeline, count: int) -> Pipeline:
    return replace(pipeline, maps=partial(pipeline.maps, landmarks=count))


def _representatives(
    pipeline: Pipeline, pieces: Pieces, groups: ChosenGroups, count: int, shown: int
) -> dict[int, str]:
    """Position → label."""
    D = _with_landmarks(pipeline, count).operators(pieces.operators[:1])
    members = {label: groups.members(label) for label in groups.labels}
    return {int(some[i]): label for label, some in members.items() for i in representatives(D[some], shown)}


def _template(pipeline: Pipeline, groups: ChosenGroups) -> list[np.ndarray] | None:
    """(V,) log area ratios a shape, of two groups of meshes; else None."""
    shapes = [pipeline.collection[i] for i in groups.shapes]
    if len(groups.labels) != 2 or None in groups.of or not all(isinstance(shape, Mesh) for shape in shapes):
        log.info("the landmarks' own answer left out: it is of two groups of meshes, all with a label")
        return None
    vertices = common_landmarks(pipeline.collection)[groups.shapes]
    points = np.stack([shape.vertices[v] for shape, v in zip(shapes, vertices, strict=True)])
    means, kept = landmark_means(points, [str(label) for label in groups.of])
    log.info("%d of %d landmarks are apart on all shapes", len(kept), vertices.shape[1])
    first, second = (means[label] for label in groups.labels)
    return [template_log_ratio(shape, p[kept], first, second) for shape, p in zip(shapes, points, strict=True)]


def _agreement(first: Sequence[np.ndarray], second: Sequence[np.ndarray], masses: Sequence[np.ndarray]) -> float:
    """Pearson's correlation over the surface, mean over the shapes."""
    return float(np.mean([correlation(*each) for each in zip(first, second, masses, strict=True)]))


def _roots(squares: Sequence[np.ndarray]) -> list[np.ndarray]:
    return [np.sqrt(s) for s in squares]


def _show(
    pipeline: Pipeline, groups: ChosenGroups, chosen: dict[int, str], fields: Sequence[Field], out: Path, azimuth: float
) -> None:
    names, up = pipeline.collection.names, pipeline.collection.up
    shapes = [pipeline.collection[i] for i in chosen]
    titles = [f"{label}\n{names[i]}" for i, label in chosen.items()]
    highlight_chart(shapes, titles, fields, up, azimuth).savefig(out / "highlighted.png")
    (out / "shapes").mkdir(exist_ok=True)
    for field in fields:
        for j, i in enumerate(chosen):
            path = out / "shapes" / f"{names[i]}_{field.name}.ply"
            save_coloured(shapes[j], field.colours(j), path, up, {field.name: field.values[j]})
    with SummaryWriter(out / "tensorboard") as writer:
        add_picture(writer, "landmark_stability/highlighted", out / "highlighted.png")


def _tell(metrics: dict[str, float], counts: Sequence[int], shapes: int) -> None:
    log.info("%d shapes; correlation with %d landmarks, mean over the shapes:", shapes, counts[-1])
    columns = {"region": "region", "function": "best function", "template": "with template", "p_value": "p",
               "accuracy": "right held out"}  # fmt: skip
    there = {key: title for key, title in columns.items() if f"{counts[0]}/{key}" in metrics}
    log.info("  %9s %s", "landmarks", " ".join(f"{title:>14}" for title in there.values()))
    for n in counts:
        log.info("  %9d %s", n, " ".join(f"{metrics[f'{n}/{key}']:14.3f}" for key in there))
    log.info("highlighted.png; coloured shapes in shapes/")
