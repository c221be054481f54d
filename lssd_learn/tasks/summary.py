"""`task=summary task.folder=DIR`: the runs of a sweep as one table, grouped by everything but the seed.

Every sweep ends with the same, also when some of its jobs failed.
"""

import csv
import logging
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import cast

import numpy as np

from lssd_learn.pieces import Pieces
from lssd_learn.runs import Run, differing, read_runs
from lssd_learn.view.sweeps import Curve, bar_chart, curve_chart

log = logging.getLogger(__name__)

FIRST = ("test/", "generalisation_error", "validation/")  # the last is what choices are made on
MOST = 8  # columns of metrics in the Markdown table where there is no test score


@dataclass(frozen=True)
class Group:
    """Runs that differ in nothing but the seed.

    Attributes:
        values: what tells this group from the others, key → value; "" is the default.
        runs: those that finished.
        failed: number of those that did not.
    """

    values: dict[str, str]
    runs: list[Run]
    failed: int

    @cached_property
    def scores(self) -> dict[str, tuple[float, float]]:
        """Metric → mean and standard deviation (n − 1) over the runs; the deviation of one run is NaN.

        A metric that some of the runs lack is left out: a mean over the others would pass for one over all.
        """
        first = self.runs[0].metrics if self.runs else {}
        names = [name for name in first if all(name in run.metrics for run in self.runs)]
        columns = {name: np.array([run.metrics[name] for run in self.runs]) for name in names}
        with np.errstate(invalid="ignore"):  # infinite ones
            return {n: (float(c.mean()), float(c.std(ddof=1)) if len(c) > 1 else np.nan) for n, c in columns.items()}


@dataclass(frozen=True)
class Table:
    """A sweep summed up.

    Attributes:
        keys: what the groups differ in.
        groups: in the order of their first runs.
        failed: the runs that failed.
    """

    keys: list[str]
    groups: list[Group]
    failed: list[Run]

    @cached_property
    def metrics(self) -> list[str]:
        """Every metric there is, test scores first, those up to a milestone after those of the whole training."""
        names = dict.fromkeys(name for group in self.groups for name in group.scores)
        return sorted(names, key=lambda name: (_rank(name), "@" in name))

    @property
    def chosen(self) -> list[str]:
        """The few metrics one looks at first; the first of them is drawn."""
        first = [name for name in self.metrics if _rank(name) < len(FIRST)]
        return first or self.metrics[:MOST]


def run(pieces: Pieces, out: Path, folder: str) -> dict[str, float]:
    """Write summary.csv, summary.md and summary.png into the folder of a sweep, from what its runs left there.

    Args:
        folder: its runs may lie at any depth.

    Returns:
        The numbers of runs, groups and failed runs.
    """
    table = summarise(read_runs(folder))
    write(table, Path(folder))
    return {"runs": sum(len(g.runs) + g.failed for g in table.groups), "groups": len(table.groups),
        "failed": len(table.failed)}  # fmt: skip


def summarise(runs: Sequence[Run]) -> Table:
    """Group runs by the overrides that differ, the seed apart; of finished runs asked for the same, the last counts."""
    keys = differing(runs)
    groups: dict[tuple, list[Run]] = {}
    for entry in runs:
        groups.setdefault(tuple(entry.overrides.get(key, "") for key in keys), []).append(entry)
    made = []
    for values, members in groups.items():
        finished = {tuple(sorted(r.overrides.items())): r for r in members if r.error is None}
        failed = sum(r.error is not None for r in members)
        made.append(Group(dict(zip(keys, values, strict=True)), list(finished.values()), failed))
    return Table(keys, made, [r for r in runs if r.error is not None])


def write(table: Table, folder: Path) -> None:
    """Write the three files, and say what came out in the log: the table, then the failed runs."""
    write_csv(table, folder / "summary.csv")
    text = to_markdown(table)
    (folder / "summary.md").write_text(text, encoding="utf-8")
    chart = to_figure(table)
    if chart is None:
        (folder / "summary.png").unlink(missing_ok=True)  # of an earlier summary
    else:
        chart.savefig(folder / "summary.png")
    log.info("%s", text.rstrip())
    log.info("summary: %s", ", ".join(str(path) for path in sorted(folder.glob("summary.*"))))


def write_csv(table: Table, path: Path) -> None:
    """One line a group: keys, n, failed, then mean and deviation of every metric; empty where there is none."""
    with path.open("w", newline="", encoding="utf-8") as stream:
        lines = csv.writer(stream)
        heads = [head for name in table.metrics for head in (name, f"{name} deviation")]
        lines.writerow([*table.keys, "n", "failed", *heads])
        for group in table.groups:
            numbers = [number for name in table.metrics for number in group.scores.get(name, (np.nan, np.nan))]
            lines.writerow([*group.values.values(), len(group.runs), group.failed,
                *("" if np.isnan(number) else number for number in numbers)])  # fmt: skip


def to_markdown(table: Table) -> str:
    """The chosen metrics as mean ± standard deviation, and below them what failed and why."""
    counts = ["n", "failed"] if table.failed else ["n"]
    heads = [*table.keys, *counts, *table.chosen]
    lines = [_line(heads), _line(["---"] * len(heads))]
    for group in table.groups:
        numbers = [str(len(group.runs)), str(group.failed)][: len(counts)]
        scores = [_shown(*group.scores[name]) if name in group.scores else "" for name in table.chosen]
        lines.append(_line([*map(_brief, group.values.values()), *numbers, *scores]))
    if table.failed:
        lines += ["", f"{len(table.failed)} failed:", ""]
        lines += [f"- {entry.title}: {entry.error}" for entry in table.failed]
    return "\n".join(lines) + "\n"


def to_figure(table: Table):
    """The first chosen metric against the number that was swept, a line for each of the other choices; bars where no
    number was swept; None where nothing finished."""
    groups = [group for group in table.groups if group.runs and table.chosen and table.chosen[0] in group.scores]
    if not groups:
        return None
    metric = table.chosen[0]
    values = {key: [_number(group.values[key]) for group in groups] for key in table.keys}
    swept = {key: len(set(numbers)) for key, numbers in values.items() if None not in numbers}
    x = max(swept, key=swept.__getitem__, default=None)
    if x is None or swept[x] < 2:
        bars = {_label(group, table.keys): group.scores[metric] for group in groups}
        return bar_chart(bars, metric)
    others = [key for key in table.keys if key != x]
    lines: dict[str, list[tuple[float, float, float]]] = {}
    for number, group in zip(values[x], groups, strict=True):
        lines.setdefault(_label(group, others), []).append((cast(float, number), *group.scores[metric]))
    curves = {name: Curve(*map(np.array, zip(*sorted(points), strict=True))) for name, points in lines.items()}
    return curve_chart(curves, x, metric)


def _rank(metric: str) -> int:
    return next((rank for rank, start in enumerate(FIRST) if metric.startswith(start)), len(FIRST))


def _label(group: Group, keys: Sequence[str]) -> str:
    return " ".join(f"{key}={_brief(group.values[key])}" for key in keys if group.values[key])


def _line(cells: Sequence[str]) -> str:
    return f"| {' | '.join(cell.replace('|', '&#124;') for cell in cells)} |"


def _shown(mean: float, deviation: float) -> str:
    return f"{mean:.4g}" if np.isnan(deviation) else f"{mean:.4g} ± {deviation:.2g}"


def _brief(value: str) -> str:
    """A value as typed; a long number, as a search draws it, to four digits."""
    number = _number(value)
    return value if number is None or len(value) <= 6 else f"{number:.4g}"


def _number(value: str) -> float | None:
    try:
        number = float(value)
    except ValueError:
        return None
    return number if np.isfinite(number) else None
