"""The table of a sweep as it is left in its folder: summary.csv, summary.md, summary.png."""

import csv
import logging
from collections.abc import Sequence
from pathlib import Path
from typing import cast

import numpy as np

from lssd_learn.sweeps.table import Group, Table
from lssd_learn.view.sweeps import Curve, bar_chart, curve_chart

log = logging.getLogger(__name__)


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
