"""Progress with the time left, for anything over a few seconds: a bar, or lines where there is no terminal."""

import logging
import time
from collections.abc import Iterable, Iterator
from typing import TypeVar

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

log = logging.getLogger(__name__)

T = TypeVar("T")

LINE = 10.0  # seconds between two lines in a log


def bar(console: Console, **options) -> Progress:
    """A bar with a description, how many are done, the time gone and the time left."""
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
        TextColumn("left"),
        TimeRemainingColumn(),
    )
    return Progress(*columns, console=console, **options)


def track(items: Iterable[T], what: str, total: int | None = None) -> Iterator[T]:
    """Yield `items` while standard error shows how many are done and how long the rest will take.

    Args:
        items: anything that can be iterated, a generator of parallel results included.
        what: a few words that name the work.
        total: number of items, when `items` has no length.
    """
    total = len(items) if total is None else total
    console = Console(stderr=True)
    if console.is_terminal:
        with bar(console) as shown:
            yield from shown.track(items, description=what, total=total)
        return
    start = told = time.monotonic()
    for done, item in enumerate(items, start=1):
        now = time.monotonic()
        if now - told > LINE:
            told = now
            log.info("%s %d/%d, %.0f s left", what, done, total, (now - start) / done * (total - done))
        yield item


def duration(seconds: float) -> str:
    """A time in the unit that suits it, as in 45 s, 6.6 minutes, 3.2 hours."""
    for most, unit, length in ((90, "s", 1), (90, "minutes", 60), (48, "hours", 3600)):
        if seconds < most * length:
            return f"{seconds / length:.2g} {unit}"
    return f"{seconds / 86400:.2g} days"
