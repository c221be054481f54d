"""The measurements of `task=benchmark` as a table: its rows, how they grow with n, and how they are shown and kept."""

import csv
import re
from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from io import StringIO
from pathlib import Path
from typing import NamedTuple, cast

import numpy as np
from rich.box import SIMPLE
from rich.console import Console
from rich.table import Table

BARE_LOOP = "bare loop"


@dataclass(frozen=True)
class Row:
    """One line of the table.

    Attributes:
        stage: also the first part of the metrics' names.
        threads: that both sides computed with.
        seconds, megabytes: ours; seconds are the processor's on one thread and those that pass on several (`cache`:
            always); megabytes is None where they are another row's.
        against: what the peer is; empty where there is none.
        peer_seconds, peer_megabytes: the peer's, None where there is none.
        difference: the largest difference between the two results; None where they are not compared.
        exponent: e where the seconds of this stage grow as nᵉ; of its row of most shapes.
    """

    stage: str
    threads: int
    seconds: float
    megabytes: float | None = None
    against: str = ""
    peer_seconds: float | None = None
    peer_megabytes: float | None = None
    difference: float | None = None
    exponent: float | None = None

    @property
    def ratio(self) -> float | None:
        """How many times faster ours is; against the bare loop, how many times slower, which is what ours costs."""
        if self.peer_seconds is None:
            return None
        faster = self.peer_seconds / self.seconds
        return 1 / faster if self.against == BARE_LOOP else faster

    def numbers(self) -> dict[str, float]:
        """The measurements that are there."""
        names = ("seconds", "megabytes", "peer_seconds", "peer_megabytes", "ratio", "difference")
        return {name: getattr(self, name) for name in names if getattr(self, name) is not None}


class Growth(NamedTuple):
    """Seconds (m,) of m numbers of shapes, and the exponent e of seconds ~ nᵉ; None for a single number."""

    sizes: list[int]
    seconds: list[float]
    exponent: float | None

    def at(self, n: int) -> float:
        """The seconds of n shapes on the line through log n and log seconds; it has an exponent."""
        return float(np.exp(np.mean(np.log(self.seconds)) + self.exponent * (np.log(n) - np.mean(np.log(self.sizes)))))


STAGES = ("eigenbases", "network", "latent", "operators", "scaling")  # with a row for each number of shapes


def growths(rows: Sequence[Row]) -> dict[str, Growth]:
    """The growth of each stage, by the name its exponent has among the metrics; those without a row left out.

    The exponent is the slope of the least-squares line through log n and log seconds.
    """
    series = {f"{stage}/exponent": _by_size(rows, stage) for stage in STAGES}
    series = {name: {n: row.seconds for n, row in found.items()} for name, found in series.items()}
    peer = {n: row.peer_seconds for n, row in _by_size(rows, "latent").items() if row.peer_seconds is not None}
    series["latent/peer_exponent"] = peer
    return {name: _growth(seconds) for name, seconds in series.items() if seconds}


def with_exponents(rows: Sequence[Row]) -> list[Row]:
    """The rows, with the exponent of each stage at its row of most shapes."""
    of = {}
    for name, growth in growths(rows).items():
        of[f"{name.removesuffix('/exponent')}/n{max(growth.sizes)}"] = growth.exponent
    return [replace(row, exponent=of.get(row.stage)) for row in rows]


def megabytes_at(rows: Sequence[Row], n: int) -> float:
    """The memory of the latent stage for n shapes, on the line through what it was for other numbers of shapes."""
    found = _by_size(rows, "scaling")
    return float(np.polyval(np.polyfit(list(found), [cast(float, row.megabytes) for row in found.values()], 1), n))


def _by_size(rows: Sequence[Row], stage: str) -> dict[int, Row]:
    found = [(re.fullmatch(rf"{stage}/n(\d+)", row.stage), row) for row in rows]
    return {int(match[1]): row for match, row in found if match}


def _growth(seconds: dict[int, float]) -> Growth:
    sizes, values = list(seconds), list(seconds.values())
    exponent = float(np.polyfit(np.log(sizes), np.log(values), 1)[0]) if len(sizes) > 1 else None
    return Growth(sizes, values, exponent)


def write_csv(rows: Sequence[Row], path: Path) -> None:
    """One line a row; what is not there stays empty."""
    names = [*(field.name for field in fields(Row)), "ratio"]
    with path.open("w", newline="") as stream:
        table = csv.writer(stream)
        table.writerow(names)
        table.writerows([getattr(row, name) for name in names] for row in rows)


def render(rows: Sequence[Row], title: str) -> str:
    """The table as text."""
    table = Table(title=title, box=SIMPLE, title_justify="left")
    table.add_column("stage")
    for heading in ("threads", "seconds", "MB", "peer", "seconds", "MB", "ratio", "difference", "exponent"):
        table.add_column(heading, justify="right")
    for row in rows:
        table.add_row(
            row.stage,
            str(row.threads),
            _shown(row.seconds, ".3g"),
            _shown(row.megabytes, ".0f"),
            row.against,
            _shown(row.peer_seconds, ".3g"),
            _shown(row.peer_megabytes, ".0f"),
            _shown(row.ratio, ".3g"),
            _shown(row.difference, ".0e"),
            _shown(row.exponent, ".2f"),
        )
    text = StringIO()
    Console(file=text, width=120).print(table)
    return "\n".join(line.rstrip() for line in text.getvalue().rstrip().splitlines())


def _shown(value: float | None, form: str) -> str:
    return "" if value is None else format(value, form)
