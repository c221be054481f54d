"""`task=map_benchmark`: the table that papers on correspondence print, of a public benchmark or of generated shapes."""

import logging
from collections.abc import Sequence
from pathlib import Path
from typing import Any, cast

import numpy as np

from lssd_learn.collections import Collection
from lssd_learn.collections.groups import choose_group
from lssd_learn.collections.parallel import in_parallel
from lssd_learn.errors import InputError, check_positive, check_whole, reading
from lssd_learn.maps import ComputedMaps, area_under_curve
from lssd_learn.measures.map_scores import Entry, pairs_by, score
from lssd_learn.pieces import Pieces
from lssd_learn.view.errors import cumulative_chart
from lssd_learn.written import write_rows

log = logging.getLogger(__name__)

TABLE, PAIRS, PICTURE = "map_benchmark.csv", "pairs.csv", "curve.png"
BAD = 0.05  # mean error of a map that is not good any more

Chosen = list[tuple[str, int, int]]  # kind, source, target
Row = dict[str, Any]


def run(
    pieces: Pieces,
    out: Path,
    pairs: int | str | None = None,
    by: str | None = None,
    points: int | None = 500,
    threshold: float = 0.25,
) -> dict[str, float]:
    """Score the maps of the run's method on pairs of shapes whose true maps are known.

    Writes map_benchmark.csv, a row a kind of pairs; pairs.csv, a row a pair, the worst first; and a picture of the
    curve: for each error the share of points that are below it.

    Args:
        pairs: None is all that are known; a number, so many drawn at random; a file with a line a pair, two names, or a
            line a shape, for all pairs of these.
        by: a group of the collection: so many pairs within its labels, and so many between them, are told apart.
        points: of each pair that are scored, drawn at random; null is all, as papers do: distances take the most time.
        threshold: where the curve ends that the area is taken under.

    Returns:
        Of each kind "KIND/error", the mean geodesic error over √area; "/auc", the area under the curve; "/flipped", of
        bodies, the share of points on the wrong side; "/turned", the share of the area that turns over; "/worst", the
        error of the worst pair; "/seconds", of processor time a pair; and, where a method tells the quality of its
        maps, "/quality", its mean, "/trusted", how many are, and "/trusted_bad" and "/untrusted_bad", the shares of
        these and of the others that are off by more than 5 % of √area.

    Raises:
        InputError: a collection whose true maps nobody knows, maps=correspondence, a group or pairs that there are not.
    """
    collection, pipeline = pieces.pipeline.collection, pieces.pipeline
    if not collection.vertex_maps:
        raise InputError(
            "task=map_benchmark: expected a collection whose true maps are known: collection=benchmark or remeshed"
        )
    if not pipeline.computes_maps:
        raise InputError("task=map_benchmark: expected maps that are computed, such as maps=auto")
    if points is not None:
        check_whole("task.points", points, 1)
    check_positive("task.threshold", threshold)
    chosen = choose(collection, pairs, by, pieces.seed)
    maker = cast(ComputedMaps, pipeline.maps(pipeline.bases, collection))
    unordered = sorted({(min(i, j), max(i, j)) for _, i, j in chosen})
    ways = [[pair for pair in chosen if (min(pair[1:]), max(pair[1:])) == some] for some in unordered]
    found = in_parallel(_scored, range(len(ways)), "maps", pipeline.workers, maker, ways, points)
    scored: list[tuple[Row, np.ndarray]] = [one for some in found for one in some]
    kinds = list(dict.fromkeys(kind for kind, _, _ in chosen))
    metrics, table, curves = {}, [], {}
    for kind in kinds:
        some = [(row, errors) for row, errors in scored if row["kind"] == kind]
        curves[kind] = np.concatenate([errors for _, errors in some])
        told = summary([row for row, _ in some], curves[kind], threshold, maker.level)
        table.append({"kind": kind, "pairs": len(some)} | told)
        metrics |= {f"{kind}/{name}": value for name, value in told.items()}
    write_rows(table, out / TABLE)
    write_rows(sorted((row for row, _ in scored), key=lambda row: row["error"], reverse=True), out / PAIRS)
    cumulative_chart(curves, "geodesic error / √area", threshold).savefig(out / PICTURE, dpi=150)
    _tell(table)
    log.info("%d pairs: %s, %s, %s", len(chosen), out / TABLE, PAIRS, PICTURE)
    return metrics


def choose(collection: Collection, pairs: int | str | None, by: str | None, seed: int) -> Chosen:
    """(kind, source, target) of the pairs that are scored; arguments as of `run`.

    Raises:
        InputError: a group or pairs that there are not.
    """
    known = sorted(collection.vertex_maps)
    if by is not None:
        most = len(known) if pairs is None else pairs
        check_whole("task.pairs", most, 1)
        return pairs_by(collection, choose_group(collection, by, "task.by"), int(most), np.random.default_rng(seed))
    if isinstance(pairs, str):
        listed = _listed(Path(pairs).expanduser(), collection.names, set(known))
        return [("all", i, j) for i, j in listed]
    if pairs is not None:
        check_whole("task.pairs", pairs, 1)
        drawn = np.random.default_rng(seed).permutation(len(known))[: int(pairs)]
        known = [known[n] for n in drawn]
    return [("all", i, j) for i, j in known]


def _listed(file: Path, names: Sequence[str], known: set[tuple[int, int]]) -> list[tuple[int, int]]:
    """The pairs of a file: of two names a line, or all of one name a line."""
    with reading(file):
        lines = [line.replace(",", " ").split() for line in file.read_text(encoding="utf-8-sig").splitlines()]
    rows, position = [line for line in lines if line], {name: i for i, name in enumerate(names)}
    position |= {f"{name}.{kind}": i for name, i in position.items() for kind in ("off", "ply", "obj")}
    for row in rows:
        if len(row) > 2 or any(name not in position for name in row):
            raise InputError(
                f"{file}: expected one or two names of shapes a line, such as {names[0]}, got {' '.join(row)}"
            )
    if len({len(row) for row in rows}) != 1:
        raise InputError(f"{file}: expected a name a line, or two on each line, got {len(rows)} lines of both")
    if len(rows[0]) == 1:
        shapes = [position[name] for (name,) in rows]
        return [(i, j) for i in shapes for j in shapes if (i, j) in known]
    found = [(position[a], position[b]) for a, b in rows]
    lacking = next((pair for pair in found if pair not in known), None)
    if lacking is not None:
        a, b = (names[k] for k in lacking)
        raise InputError(f"{file}: expected pairs whose true map is known, got {a} and {b}")
    return found


def _scored(p: int, maker: ComputedMaps, ways: Sequence[Chosen], points: int | None) -> list[tuple[Row, np.ndarray]]:
    """A row and the errors of each direction that is asked for of one pair."""
    collection, (_, a, b) = maker.shapes, ways[p][0]
    entry = Entry.compute(maker, min(a, b), max(a, b))
    scored = []
    for kind, i, j in ways[p]:
        told, errors = score(entry, collection, i, j, points)
        scored.append(({"kind": kind, "source": collection.names[i], "target": collection.names[j]} | told, errors))
    return scored


def summary(rows: Sequence[Row], errors: np.ndarray, threshold: float, level: float) -> dict[str, float]:
    """What the table tells of pairs of a kind.

    Args:
        rows: of the pairs, see `score`.
        errors: of all their points.
        threshold: see `run`.
        level: quality that is trusted.
    """
    names = [name for name in rows[0] if isinstance(rows[0][name], float) and all(name in row for row in rows)]
    means = {name: float(np.mean([row[name] for row in rows])) for name in names}
    away = np.array([row["error"] for row in rows])
    told = {"error": means["error"], "median": float(np.median(errors)), "worst": float(away.max())}
    told["auc"] = area_under_curve(errors, threshold)
    told |= {name: means[name] for name in ("flipped", "turned", "seconds", "quality") if name in means}
    if "quality" in means:
        trusted = np.array([row["quality"] for row in rows]) >= level
        told["trusted"] = int(trusted.sum())
        for name, some in (("trusted_bad", trusted), ("untrusted_bad", ~trusted)):
            if some.any():
                told[name] = float((away[some] > BAD).mean())
    return told


def _tell(table: Sequence[Row]) -> None:
    """The table, in the units of papers: errors times 100, shares in percent."""
    columns = {
        "error": ("error", 100, ".2f"),
        "worst": ("worst", 100, ".2f"),
        "AUC": ("auc", 1, ".3f"),
        "flips %": ("flipped", 100, ".2f"),
        "turned %": ("turned", 100, ".2f"),
        "s": ("seconds", 1, ".2f"),
        "quality": ("quality", 1, ".2f"),
    }
    log.info("%-14s %6s%s", "", "pairs", "".join(f"{head:>9}" for head in columns))
    for row in table:
        shown = [f"{row[name] * unit:{form}}" if name in row else "" for name, unit, form in columns.values()]
        log.info("%-14s %6d%s", row["kind"], row["pairs"], "".join(f"{text:>9}" for text in shown))
