"""`task=map_quality`: how good computed maps are, and how long they take, on pairs whose true map is known."""

import logging
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from scipy.spatial.distance import cdist

from lssd_learn import maps
from lssd_learn.collections import Collection
from lssd_learn.errors import InputError, check_whole
from lssd_learn.measures.map_scores import Entry, pairs_by, score
from lssd_learn.pieces import Pieces
from lssd_learn.progress import track
from lssd_learn.view.errors import cumulative_chart
from lssd_learn.written import write_rows

log = logging.getLogger(__name__)

METHODS = {
    "auto": maps.AutoMaps,
    "kernel_matching": maps.KernelMatchingMaps,
    "registration": maps.RegistrationMaps,
    "landmarks": maps.LandmarkMaps,
    "adjoint": maps.AdjointMaps,
}
TABLE, PICTURE = "map_errors.csv", "map_errors.png"


def run(pieces: Pieces, out: Path, methods: Sequence[str], pairs: int, points: int) -> dict[str, float]:
    """Score methods on pairs of three kinds: Shape-DNA neighbours, of one pose, of two poses.

    Writes map_errors.csv, a row a pair and method, and a picture.

    Args:
        methods: names of choices of the config group `maps`, each with its defaults.
        pairs: of each kind, as many as there are at most.
        points: vertices of the target that are scored, drawn at random; geodesic distances take the most time.

    Returns:
        "METHOD/KIND/error", mean geodesic error over √area; "METHOD/KIND/flipped", share of vertices on the wrong side,
        and "METHOD/KIND/flips", pairs where that is over a tenth, of bodies; "METHOD/seconds" of processor time a pair.

    Raises:
        InputError: a collection whose true maps nobody knows, an unknown method, landmarks that are not there.
    """
    check_whole("task.pairs", pairs, 1)
    check_whole("task.points", points, 1)
    collection = pieces.pipeline.collection
    if not collection.vertex_maps:
        raise InputError("task=map_quality: expected a collection whose true maps are known: collection=remeshed")
    for name in methods:
        if name not in METHODS:
            raise InputError(f"task.methods: expected some of {', '.join(METHODS)}, got {name}")
    bases = pieces.pipeline.bases
    makers = {name: METHODS[name](bases, collection) for name in methods}
    chosen = choose_pairs(collection, np.stack([basis.evals for basis in bases]), pairs, pieces.seed)
    rows = []
    for kind, i, j in track(chosen, "maps"):
        for name, maker in makers.items():
            entry = Entry.compute(maker, min(i, j), max(i, j))
            rows.append({"method": name, "kind": kind, "source": collection.names[i], "target": collection.names[j]})
            rows[-1] |= score(entry, collection, i, j, points)[0]
    write_rows(rows, out / TABLE)
    metrics = {}
    for name in methods:
        for kind in dict.fromkeys(row["kind"] for row in rows):
            some = [row for row in rows if (row["method"], row["kind"]) == (name, kind)]
            metrics[f"{name}/{kind}/error"] = float(np.mean([row["error"] for row in some]))
            if "flipped" in some[0]:
                metrics[f"{name}/{kind}/flipped"] = float(np.mean([row["flipped"] for row in some]))
                metrics[f"{name}/{kind}/flips"] = sum(row["flipped"] > 0.1 for row in some)
            log.info("%-16s %-14s error %.4f over √area", name, kind, metrics[f"{name}/{kind}/error"])
        metrics[f"{name}/seconds"] = float(np.mean([row["seconds"] for row in rows if row["method"] == name]))
    by_method = {name: np.array([row["error"] for row in rows if row["method"] == name]) for name in methods}
    cumulative_chart(by_method, "mean geodesic error of a map / √area").savefig(out / PICTURE, dpi=150)
    log.info("%d maps: %s, %s", len(rows), out / TABLE, PICTURE)
    return metrics


def choose_pairs(collection: Collection, evals: np.ndarray, count: int, seed: int) -> list[tuple[str, int, int]]:
    """(kind, source, target), `count` of each kind at most: "neighbours", "same_pose" and "other_pose".

    Args:
        collection: n shapes; without a group "pose" only the first kind is there.
        evals: (n, k) their spectra.
        count: of each kind.
        seed: of the choice.
    """
    rng, n = np.random.default_rng(seed), len(collection)
    away = cdist(evals, evals)
    np.fill_diagonal(away, np.inf)
    pairs = [("neighbours", int(away[j].argmin()), int(j)) for j in rng.permutation(n)[:count]]
    return pairs + (pairs_by(collection, "pose", count, rng) if "pose" in collection.groups else [])
