"""The runs of a sweep as one table, grouped by everything but the seed."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from lssd_learn.sweeps.runs import Run, differing

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


def _rank(metric: str) -> int:
    return next((rank for rank, start in enumerate(FIRST) if metric.startswith(start)), len(FIRST))
