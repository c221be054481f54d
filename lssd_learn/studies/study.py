"""`task=study task.folder=DIR`: the paper's regression study from the sweeps below a folder, beside its own numbers.

    operators   experiment=paper_regression: networks × numbers of functions × nets × seeds
    wide        experiment=paper_wide: the same nets on operators from more of the spectrum than are kept
    pool        experiment=paper_pool: fifteen PointNets on one seed
    pointnet    experiment=paper_pointnet: the best of them by validation, all seeds
    kernel      experiment=kernel, and
    baselines   task=baselines, what is not the paper's

A sweep that is not there, or not done yet, is left out.
"""

import csv
import logging
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from tensorboard.backend.event_processing.event_accumulator import EventAccumulator

from lssd_learn.errors import InputError
from lssd_learn.pieces import Pieces
from lssd_learn.studies.baselines import WORDS
from lssd_learn.studies.study_charts import functions_chart, trends_chart
from lssd_learn.sweeps.runs import Run, read_runs
from lssd_learn.view.sweeps import Curve

log = logging.getLogger(__name__)

# Column of the paper's table → our metric.
SCORES = {
    "MSE@500": "test/mse@500",
    "GE@500": "generalisation_error@500",
    "MSE@1K": "test/mse",
    "L1@1K": "test/l1",
}

# Paper, Table "Complementary statistics".
PUBLISHED = {
    "PointNet": (0.057, 0.020, 0.061, 0.192),
    "MLP, clique, 40": (0.033, 0.009, 0.032, 0.134),
    "CNN, nearest_20, 40": (0.027, 0.010, 0.013, 0.086),
    "CNN, clique, 40": (0.009, 0.003, 0.005, 0.050),
}

NETWORKS = {"clique": "clique", "nearest_20": "20 nearest", "nearest_10": "10 nearest"}


class Score(NamedTuple):
    """Mean and standard deviation (n − 1; NaN of one) over n runs."""

    mean: float
    deviation: float
    n: int

    def __str__(self) -> str:
        places = 5 if abs(self.mean) < 0.004 else 4
        mean, deviation = (f"{number:.{places}f}".replace("0.", ".", 1) for number in (self.mean, self.deviation))
        return mean if np.isnan(self.deviation) else f"{mean} ± {deviation}"


Row = Mapping[str, Score]  # column → score


def run(pieces: Pieces, out: Path, folder: str) -> dict[str, float]:
    """Write table.csv, table.md, mse.png and trends.png.

    Args:
        folder: with the sweeps named above, at any depth.

    Returns:
        The score of every row in every column.

    Raises:
        InputError: no such folder, or none of the sweeps in it.
    """
    sweeps = read_sweeps(Path(folder))
    rows = make_rows(sweeps)
    write_csv(rows, out / "table.csv")
    text = to_markdown(rows, best_of_pool(sweeps.get("pool", [])))
    (out / "table.md").write_text(text, encoding="utf-8")
    if "operators" in sweeps:
        make_figure(sweeps, rows).savefig(out / "mse.png")
    if panels := make_trends(sweeps, Path(folder)):
        trends_chart(panels, "MSE").savefig(out / "trends.png")
    log.info("%s", text.rstrip())
    return {f"{name}/{column}": score.mean for name, row in rows.items() for column, score in row.items()}


def read_sweeps(folder: Path) -> dict[str, list[Run]]:
    """Sweep → its finished runs, by the name of the folder they lie in."""
    sweeps: dict[str, list[Run]] = {}
    for entry in read_runs(folder):
        name = Path(entry.name).parent.name or Path(entry.name).name
        if entry.error is None:
            sweeps.setdefault(name, []).append(entry)
        else:
            log.warning("left out: %s: %s", entry.title, entry.error)
    known = ("operators", "wide", "pool", "pointnet", "kernel", "baselines")
    for name in known:
        if name not in sweeps:
            log.info("no finished runs of %s below %s", name, folder)
    if not set(known) & set(sweeps):
        raise InputError(f"{folder}: expected the sweeps {', '.join(known)}, each in a folder of its name; found none")
    return {name: sweeps[name] for name in known if name in sweeps}


def make_rows(sweeps: Mapping[str, Sequence[Run]]) -> dict[str, Row]:
    """What stands in the table, by name: PointNet, the nets on operators, ours, baselines."""
    rows: dict[str, Row] = {}
    if "pointnet" in sweeps:
        rows["PointNet"] = _scores(sweeps["pointnet"])
    for sweep, suffix in (("operators", ""), ("wide", ", k = 80")):
        for key, runs in _by(sweeps.get(sweep, []), "net", "network", "latent.keep").items():
            net, network, keep = key
            rows[f"{net.upper()}, {network}, {keep or 40}{suffix}"] = _scores(runs)
    if "operators" in sweeps:
        ridge = _by([r for r in sweeps["operators"] if r.overrides["net"] == "cnn"], "network", "latent.keep")
        for (network, keep), runs in ridge.items():
            if keep == "40":
                rows[f"ridge, {network}, 40"] = _scores(
                    runs, {"MSE@1K": "reference/ridge/mse", "L1@1K": "reference/ridge/l1"}
                )
    if "kernel" in sweeps:
        rows["kernel machine"] = _scores(sweeps["kernel"], _closed("test/"))
    if "baselines" in sweeps:
        names = [key.split("/")[1] for key in sweeps["baselines"][0].metrics if key.endswith("/mse")]
        for name in dict.fromkeys(names):
            rows[WORDS.get(name, name)] = _scores(sweeps["baselines"], _closed(f"reference/{name}/"))
    return {name: row for name, row in rows.items() if row}


def best_of_pool(pool: Sequence[Run]) -> Run | None:
    """The one whose validation error is least."""
    return min(pool, key=lambda r: r.metrics["validation/mse"], default=None)


def write_csv(rows: Mapping[str, Row], path: Path) -> None:
    """A line a row: mean, deviation and the paper's number of every column; empty where there is none."""
    with path.open("w", newline="", encoding="utf-8") as stream:
        table = csv.writer(stream)
        table.writerow(["row", "n", *(f"{column}{what}" for column in SCORES for what in ("", " deviation", " paper"))])
        for name, row in rows.items():
            published = dict(zip(SCORES, PUBLISHED.get(name, ()), strict=False))
            cells = []
            for column in SCORES:
                score = row.get(column)
                cells += (
                    ["", ""] if score is None else [score.mean, "" if np.isnan(score.deviation) else score.deviation]
                )
                cells.append(published.get(column, ""))
            table.writerow([name, next(iter(row.values())).n, *cells])


def to_markdown(rows: Mapping[str, Row], best: Run | None = None) -> str:
    """The table, the paper's numbers in brackets."""
    lines = [_line(["", "n", *SCORES]), _line(["---"] * (2 + len(SCORES)))]
    for name, row in rows.items():
        published = dict(zip(SCORES, PUBLISHED.get(name, ()), strict=False))
        cells = [f"{row[c]}" if c in row else "" for c in SCORES]
        cells = [f"{cell} ({published[c]:.3f})".replace("(0.", "(.") if c in published else cell
            for c, cell in zip(SCORES, cells, strict=True)]  # fmt: skip
        lines.append(_line([name, str(next(iter(row.values())).n), *cells]))
    lines += ["", "Mean ± standard deviation over n seeds; in brackets the paper's number, on other bodies."]
    lines += ["@500 and @1K: the epoch best on validation up to there; what has no epochs stands under @1K."]
    if best is not None:
        chosen = " ".join(f"{key}={best.overrides[key]}" for key in ("net.variant", "net.learning_rate"))
        lines.append(f"Best of the pool by validation: {chosen}, validation MSE {best.metrics['validation/mse']:.4f}.")
    return "\n".join(lines) + "\n"


def make_figure(sweeps: Mapping[str, Sequence[Run]], rows: Mapping[str, Row]):
    """The paper's Figure `mse`: test error at 500 epochs against the number of functions."""
    points = (
        (net, network, int(keep), *_score(some, SCORES["MSE@500"])[:2])
        for (net, network), runs in _by(sweeps["operators"], "net", "network").items()
        for (keep,), some in _by(runs, "latent.keep").items()
    )
    return functions_figure(points, rows["PointNet"]["MSE@500"].mean if "PointNet" in rows else None)


def functions_figure(points: Iterable[tuple[str, str, int, float, float]], pointnet: float | None):
    """The same of net, network, number of functions, mean and deviation of the score; and that of PointNet."""
    drawn: dict[str, dict[str, list]] = {"mlp": {}, "cnn": {}}
    for net, network, *point in points:
        drawn[net].setdefault(f"{net.upper()}, {NETWORKS.get(network, network)}", []).append(point)
    lines, dots = (
        {name: Curve(*np.array(sorted(some), float).T) for name, some in drawn[net].items()} for net in ("mlp", "cnn")
    )
    levels = {} if pointnet is None else {"PointNet": pointnet}
    return functions_chart(lines, dots, levels, "test MSE, 500 epochs")


def make_trends(sweeps: Mapping[str, Sequence[Run]], folder: Path) -> list[dict[str, dict[str, np.ndarray]]]:
    """The paper's training trends, on the first seed: PointNet beside the MLP, and beside the CNN."""
    points = _first(sweeps.get("pointnet", []))
    panels = []
    for net in ("mlp", "cnn"):
        wanted = {"net": net, "network": "clique", "latent.keep": "40"}
        operators = _first([r for r in sweeps.get("operators", []) if wanted.items() <= r.overrides.items()])
        if points and operators:
            panels.append({"PointNet": _curves(folder / points.name), net.upper(): _curves(folder / operators.name)})
    return panels


def _first(runs: Iterable[Run]) -> Run | None:
    return next((r for r in runs if r.overrides.get("seed", "0") == "0"), None)


def _curves(run: Path) -> dict[str, np.ndarray]:
    events = EventAccumulator(str(run / "tensorboard"), size_guidance={"scalars": 0})
    events.Reload()
    return {part: np.array([e.value for e in events.Scalars(f"{part}/mse")]) for part in ("train", "validation")}


def _by(runs: Iterable[Run], *keys: str) -> dict[tuple[str, ...], list[Run]]:
    """Runs by what they were asked for."""
    groups: dict[tuple[str, ...], list[Run]] = {}
    for entry in runs:
        groups.setdefault(tuple(entry.overrides.get(key, "") for key in keys), []).append(entry)
    return groups


def _scores(runs: Sequence[Run], metrics: Mapping[str, str] = SCORES) -> Row:
    return {c: _score(runs, metric) for c, metric in metrics.items() if all(metric in r.metrics for r in runs)}


def _closed(prefix: str) -> dict[str, str]:
    """Columns of what is fitted in closed form: it has no epochs, and stands where training ends."""
    return {"MSE@1K": f"{prefix}mse", "L1@1K": f"{prefix}l1"}


def _score(runs: Sequence[Run], metric: str) -> Score:
    values = np.array([r.metrics[metric] for r in runs])
    return Score(float(values.mean()), float(values.std(ddof=1)) if len(values) > 1 else np.nan, len(values))


def _line(cells: Sequence[str]) -> str:
    return f"| {' | '.join(cells)} |"
