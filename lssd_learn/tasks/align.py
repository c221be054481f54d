"""`task=align`: which shape of one group is which of another, with no map between the two.

Each group has a network and a latent space of its own. Beside it what the older base-shape differences make of the same
maps, for every choice of a base in each group. The paper's Figure `ret_2`.
"""

import logging
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import product
from pathlib import Path

import numpy as np
import torch
from torch import Tensor

from lssd_learn.collections.base import Collection
from lssd_learn.collections.groups import choose_groups
from lssd_learn.errors import InputError, check_positive
from lssd_learn.exploration import align, base_shape_differences
from lssd_learn.latent.base_shape import BaseShapes
from lssd_learn.pieces import Pieces
from lssd_learn.pipeline import Pipeline
from lssd_learn.progress import track
from lssd_learn.shapes import Shape
from lssd_learn.view.sheets import shape_sheet, write_sheets
from lssd_learn.written import write_columns

log = logging.getLogger(__name__)

TABLE = "alignment.csv"
PAINTED = 12  # pairs at most
ALONE = -1  # in the place of a partner


@dataclass(frozen=True)
class _Bases:
    """What base-shape differences make of the alignment: `partners` (p, q, n), for each pair of bases one a shape."""

    partners: np.ndarray

    def right(self, true: np.ndarray) -> np.ndarray:
        """(p, q) the part of the shapes that are paired rightly, given the right partners (n,)."""
        return (self.partners == true).mean(2)


def run(
    pieces: Pieces,
    out: Path,
    group: str | None = None,
    labels: Sequence[str] = (),
    truth: str | None = None,
    unmatched: float | None = None,
    bases: bool = True,
    azimuth: float = 20.0,
) -> dict[str, float]:
    """Write alignment.csv and alignment.png, and print which shape is paired with which.

    Args:
        group, labels: two groups, see `choose_groups`; other shapes are left out.
        truth: another grouping, whose labels say which shapes are the same; null is not known. A shape whose label the
            other group lacks is right without a partner.
        unmatched: of `align`; null pairs every shape of the smaller group.
        bases: compare with base-shape differences.
        azimuth: degrees from which the shapes are seen.

    Returns:
        "pairs", "alone" (shapes of the smaller group without a partner), "cost" (the mean) and, where the truth is
        known, "right" (a part of 1), "chance", "bases/right" (the mean over all pairs of bases), "bases/failed" (the
        part of all pairs of bases with a wrong partner anywhere), "bases/failed_same" (of those of two shapes that are
        the same).

    Raises:
        InputError: as `choose_groups`; not two groups; a truth that does not say which shape is which.
    """
    if unmatched is not None:
        check_positive("task.unmatched", unmatched)
    pipeline = pieces.pipeline
    groups = choose_groups(pipeline.collection, group, labels)
    if len(groups.labels) != 2:
        raise InputError(f"task.labels: expected two groups to align, {groups.name} has {len(groups.labels)}")
    if pipeline.fitted is not None:
        raise InputError("data.protocol: expected transductive; each group has a latent space of its own")
    members = sorted((groups.members(label) for label in groups.labels), key=len)
    first, second = (replace(pipeline, collection=pipeline.collection[some]) for some in members)
    names = [str(groups.of[list(groups.shapes).index(some[0])]) for some in members]
    true = None if truth is None else _truth(pipeline.collection, truth, *members)
    alignment = align(first.operators(pieces.operators), second.operators(pieces.operators), unmatched)
    partners, costs = np.full(len(members[0]), ALONE), np.full(len(members[0]), np.nan)
    partners[alignment.pairs[:, 0]], costs[alignment.pairs[:, 0]] = alignment.pairs[:, 1], alignment.costs
    pairs = len(alignment.pairs)
    found: dict[str, float] = {"pairs": pairs, "alone": len(partners) - pairs}
    found |= {"cost": float(alignment.costs.mean())} if pairs else {}
    others = _from_bases(first, second, pieces.operators) if bases else None
    if true is not None:
        found |= {"right": float((partners == true).mean()), "chance": 1 / len(members[1])}
        if others is not None:
            right = others.right(true)
            there = np.flatnonzero(true != ALONE)
            same = right[there, true[there]]
            found |= {"bases/right": float(right.mean()), "bases/failed": float((right < 1).mean())}
            found |= {"bases/failed_same": float((same < 1).mean())}

    here, there = ([str(name) for name in _titles(part.collection, truth)] for part in (first, second))
    rows = _rows(first, second, names, (here, there), partners, others, true)
    sheet = shape_sheet(rows, pipeline.collection.up, azimuth, size=200)
    sheet.savefig(out / "alignment.png")
    scenes = {f"alignment/{title}": list(row.values()) for title, row in list(rows.items())[:2] if row}
    write_sheets(out / "tensorboard", {"alignment": sheet}, scenes, pipeline.collection.up)
    paired = ["" if j == ALONE else second.collection.names[int(j)] for j in partners]
    columns = {"name": first.collection.names, "partner": paired}
    columns |= {"cost": ["" if np.isnan(cost) else float(cost) for cost in costs]}
    if true is not None:
        columns |= {"right": [int(found == wanted) for found, wanted in zip(partners, true, strict=True)]}
    write_columns(columns, out / TABLE)
    _tell(found, names, first.collection.names, paired, others)
    return found


def _titles(collection: Collection, truth: str | None) -> Sequence[str]:
    """What a shape is called in the picture: its label where that says which it is."""
    return collection.names if truth is None else collection.groups[truth].tolist()


def _truth(collection: Collection, name: str, first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """(n,) for each shape of the first group the place of the same one in the second, `ALONE` where there is none.

    Raises:
        InputError: no such grouping; a label that a group has twice, or no label that both have.
    """
    if name not in collection.groups:
        known = ", ".join(collection.groups) or "none"
        raise InputError(f"task.truth={name}: expected a grouping of the collection; it has {known}")
    labels = np.asarray(collection.groups[name]).astype(str)
    here, there = labels[first].tolist(), labels[second].tolist()
    if len(set(here)) < len(here) or len(set(there)) < len(there) or not set(here) & set(there):
        raise InputError(f"task.truth={name}: expected labels that each group has once, and both have")
    place = {label: j for j, label in enumerate(there)}
    return np.array([place.get(label, ALONE) for label in here])


def _from_bases(first: Pipeline, second: Pipeline, kinds: Sequence[str]) -> _Bases:
    """The same alignment by the differences from every base in each group."""
    seen = [_seen_from_each(pipeline, kinds) for pipeline in (first, second)]
    pairs = list(product(range(len(seen[0])), range(len(seen[1]))))
    partners = [align(seen[0][a], seen[1][b]).pairs[:, 1].numpy() for a, b in track(pairs, "pairs of bases")]
    return _Bases(np.array(partners).reshape(len(seen[0]), len(seen[1]), -1))


def _seen_from_each(pipeline: Pipeline, kinds: Sequence[str]) -> list[Tensor]:
    """For each base the operators (n, channels, m, m) of all shapes."""
    network = pipeline.map_network()
    if network.edges is None:  # every map is at hand
        differences = BaseShapes(network, pipeline.keep).differences
    else:
        differences = partial(base_shape_differences, network, keep=pipeline.keep)
    return [torch.stack(differences(base, kinds=kinds), dim=1) for base in range(network.n)]


def _rows(
    first: Pipeline,
    second: Pipeline,
    names: Sequence[str],
    titles: Sequence[Sequence[str]],
    partners: np.ndarray,
    others: _Bases | None,
    true: np.ndarray | None,
) -> dict[str, dict[str, Shape]]:
    """Of the picture: the first group, its partners, and those that one pair of bases gives it."""

    def row(found: np.ndarray) -> dict[str, Shape]:
        marks = [" ✗" if true is not None and j != true[i] else "" for i, j in enumerate(found)]
        shown = [(i, j) for i, j in enumerate(found[:PAINTED]) if j != ALONE]
        return {f"{titles[1][j]}{marks[i]}": second.collection[int(j)] for i, j in shown}

    here = {titles[0][i]: first.collection[i] for i in range(min(PAINTED, len(titles[0])))}
    rows = {names[0]: here, f"{names[1]}, latent": row(partners)}
    if others is not None:
        a, b = 0, 0
        if (
            true is not None and (true != ALONE).all()
        ):  # of the bases that are the same shape, those that do worst: none knows better beforehand
            a = int(others.right(true)[np.arange(len(true)), true].argmin())
            b = int(true[a])
        rows[f"{names[1]}, base {titles[0][a]}"] = row(others.partners[a, b])
    return rows


def _tell(found: dict, labels: Sequence[str], names: Sequence[str], partners: Sequence[str], others) -> None:
    log.info("%s and %s, a latent space each:", *labels)
    for name, partner in list(zip(names, partners, strict=True))[:PAINTED]:
        log.info("  %s – %s", name, partner or "nobody")
    if "right" in found:
        log.info("%.0f of %d pairs are right", found["right"] * len(names), len(names))
    if "bases/failed" in found:
        log.info(
            "base-shape differences: %.0f %% of the %d pairs of bases fail, %.0f %% of those of two same shapes; "
            "%.0f %% of their pairs are right",
            100 * found["bases/failed"],
            others.partners.shape[0] * others.partners.shape[1],
            100 * found["bases/failed_same"],
            100 * found["bases/right"],
        )
    log.info("%d pairs: %s, alignment.png", found["pairs"], TABLE)
