"""`task=baselines`: what closed-form regressions reach on the split of `task=regression`.

On the operators; on the spectra; on the differences from every training shape as the base; and, where all shapes share
their faces, on what full vertex correspondence alone gives.
"""

import csv
import logging
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import cast

import numpy as np
from torch import Tensor

from lssd_learn.collections.procrustes import centred_vertices, procrustes
from lssd_learn.errors import InputError, check_whole
from lssd_learn.latent import MapNetwork
from lssd_learn.latent.base_shape import BaseShapes
from lssd_learn.learning import Reference, Split, mean_reference, operator_features, ridge_reference
from lssd_learn.learning.references.baselines import (
    BaseScore,
    base_scores,
    spectrum_baseline,
    wide_baseline,
)
from lssd_learn.operators.vectors import live_functions, log_features
from lssd_learn.pieces import Pieces
from lssd_learn.pipeline import Pipeline
from lssd_learn.progress import track
from lssd_learn.shapes import Mesh
from lssd_learn.shapes.edges import edge_lengths, edges
from lssd_learn.tasks.training import plan

log = logging.getLogger(__name__)

KINDS = ("area", "conformal")  # the paper's differences; those that a run asks for beside them are scored too


def words(kinds: Sequence[str] = KINDS) -> dict[str, str]:
    """name → title of the baselines in the order of the metrics: the summary of a sweep shows the first eight."""
    every = "both" if len(kinds) == 2 else "all"
    first, *others = kinds
    return {
        "log_operators": f"logarithms of {every} operators",
        "operators": f"{', '.join(kinds[:-1])} and {kinds[-1]} operators",
        first: f"{first} operators",
        "base_operators_best": f"{every}, from the best base",
        "base_operators_worst": f"{every}, from the worst base",
        "shape_dna": "Shape-DNA",
        "vertices": "aligned vertices",
        "edge_lengths": "edge lengths",
        "vertex_areas": "logarithms of vertex areas",
        "base_operators_median": f"{every}, from a middling base",
        f"base_{first}_best": f"{first}, from the best base",
        f"base_{first}_median": f"{first}, from a middling base",
        f"base_{first}_worst": f"{first}, from the worst base",
        "mean": "mean of the training split",
        **{kind: f"{kind} operators" for kind in others if kind not in KINDS},
    }


WORDS = words()
RANKS = {"best": 0.0, "median": 0.5, "worst": 1.0}  # of base shapes, by their validation error


def run(pieces: Pieces, out: Path, bases: int | None = None) -> dict[str, float]:
    """Score every baseline; print them by their test error; bases.csv holds those of every base shape.

    Args:
        bases: base shapes to try, spread over the training split; None is all of it. The best is best on validation.

    Returns:
        reference/<name>/mse and /l1 on the test split and /validation/mse, for each name in `words` that there is.

    Raises:
        InputError: a collection without parameters, bases out of range.
    """
    pipeline = pieces.pipeline
    if pipeline.collection.parameters is None:
        why = pipeline.collection.lacks("parameters")
        raise InputError(f"task=baselines: expected shapes with parameters; {why}")
    parts, _ = plan(pieces, 1)
    tried = _spread(parts.train, bases)
    targets = np.asarray(pipeline.collection.parameters, dtype=np.float64)
    kinds = list(dict.fromkeys([*KINDS, *pieces.operators]))
    titles = words(kinds)

    found = {"mean": mean_reference(targets, parts)}
    found |= _from_operators(pipeline, kinds, targets, parts)
    found |= _from_base_shapes(pipeline, kinds, targets, parts, tried, out)
    found |= _from_correspondence(pipeline, targets, parts)

    width = max(28, *(len(titles[name]) for name in found))
    log.info("test error (MSE, L1) on %d shapes of ridge regression on:", len(parts.test))
    for name, baseline in sorted(found.items(), key=lambda item: item[1].mse):
        log.info("  %-*s %.5f  %.4f", width, titles[name], baseline.mse, baseline.l1)
    numbers = {"mse": "mse", "l1": "l1", "validation/mse": "validation"}
    return {
        f"reference/{name}/{key}": getattr(found[name], attribute)
        for key, attribute in numbers.items()
        for name in titles
        if name in found
    }


def _from_operators(
    pipeline: Pipeline, kinds: Sequence[str], targets: np.ndarray, parts: Split
) -> dict[str, Reference]:
    operators = pipeline.operators(kinds)
    live = live_functions(operators[parts.train])
    singles = {kind: operators[:, c : c + 1] for c, kind in enumerate(kinds) if c == 0 or kind not in KINDS}
    return {
        "log_operators": ridge_reference(log_features(operators, live).numpy(), targets, parts),
        "operators": ridge_reference(operator_features(operators), targets, parts),
        **{kind: ridge_reference(operator_features(D), targets, parts) for kind, D in singles.items()},
        "shape_dna": spectrum_baseline(np.stack([basis.evals for basis in pipeline.bases]), targets, parts),
    }


def _from_base_shapes(
    pipeline: Pipeline, kinds: Sequence[str], targets: np.ndarray, parts: Split, tried: np.ndarray, out: Path
) -> dict[str, Reference]:
    """Some of the base shapes of each kind, see `RANKS`; nothing where none has maps to all shapes."""
    collection = pipeline.collection
    maps = pipeline.maps(pipeline.bases, collection)
    network = MapNetwork.clique(pipeline.bases, None if maps.is_identity else maps)
    shapes, lost = BaseShapes(network, pipeline.keep), []
    scored = {kinds[0]: [0], "operators": range(len(kinds))}

    def differences() -> Iterator[tuple[int, Sequence[Tensor]]]:
        for base in track(tried.tolist(), "base shapes"):
            try:
                found = shapes.differences(base, kinds)
            except InputError as error:
                lost.append(error)
            else:
                yield base, found

    scores = base_scores(differences(), targets, parts, scored)
    if lost:
        log.info("%d of %d base shapes left out, for want of maps: %s", len(lost), len(tried), lost[0])
    if not scores:
        return {}
    _write(scores, list(scored), collection.names, out / "bases.csv")
    found = {}
    for kind in scored:
        ranked = sorted(scores, key=lambda entry: entry.by_kind[kind].validation)
        chosen = {word: ranked[int(rank * (len(ranked) - 1))] for word, rank in RANKS.items()}
        found |= {f"base_{kind}_{word}": entry.by_kind[kind] for word, entry in chosen.items()}
        told = ", ".join(f"{word} {collection.names[entry.base]}" for word, entry in chosen.items())
        log.info("%d base shapes, %s, by their validation error: %s", len(scores), kind, told)
    return found


def _from_correspondence(pipeline: Pipeline, targets: np.ndarray, parts: Split) -> dict[str, Reference]:
    """Nothing where shapes differ in their faces. One kind of features at a time is held, in float32."""
    kinds = {basis.connectivity for basis in pipeline.bases}
    if len(kinds) > 1 or None in kinds:
        log.info("vertices, edge lengths and vertex areas left out: the shapes are not all in vertex correspondence")
        return {}
    areas = np.stack([np.log(basis.mass).astype(np.float32) for basis in pipeline.bases])
    found = {"vertex_areas": wide_baseline(areas, targets, parts)}
    vertices, sides = centred_vertices(pipeline.collection), edges(cast(Mesh, pipeline.collection[0]).faces)
    lengths = np.stack([edge_lengths(shape, sides).astype(np.float32) for shape in vertices])
    found["edge_lengths"] = wide_baseline(lengths, targets, parts)
    del lengths
    for shape, rotation in zip(vertices, procrustes(vertices, parts.train), strict=True):
        shape[:] = shape @ rotation
    found["vertices"] = wide_baseline(vertices.reshape(len(vertices), -1), targets, parts)
    return found


def _spread(train: np.ndarray, bases: int | None) -> np.ndarray:
    if bases is None:
        return train
    check_whole("task.bases", bases, 1, len(train))
    return train[np.linspace(0, len(train) - 1, bases).round().astype(int)]


def _write(scores: Sequence[BaseScore], kinds: Sequence[str], names: Sequence[str], path: Path) -> None:
    """A line a base shape: its name, and validation MSE, test MSE and test L1 of each kind."""
    with path.open("w", newline="", encoding="utf-8") as stream:
        lines = csv.writer(stream)
        columns = ("validation/mse", "mse", "l1")
        lines.writerow(["base", *(f"{kind}/{column}" for kind in kinds for column in columns)])
        for entry in scores:
            found = [entry.by_kind[kind] for kind in kinds]
            lines.writerow([names[entry.base], *(x for b in found for x in (b.validation, b.mse, b.l1))])
