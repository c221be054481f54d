"""Progress with the time left, for anything over a few seconds: a bar in a terminal or notebook, elsewhere lines."""

import logging
import sys
import time
from collections.abc import Iterable, Iterator, Sequence, Sized
from html import escape
from typing import TypeVar, cast

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

log = logging.getLogger(__name__)

T = TypeVar("T")

LINE = 10.0  # seconds between two lines in a log
FRAME = 0.2  # and between two states of a bar in a notebook, which has none for work that ends sooner


class Bar(Progress):
    """A bar that stays below what is logged meanwhile: handlers that write to standard error write above it."""

    _moved: Sequence[logging.StreamHandler] = ()

    def start(self) -> None:
        before = sys.stderr
        super().start()  # which puts something in the place of standard error, in a terminal
        self._moved = [
            handler
            for handler in logging.root.handlers
            if isinstance(handler, logging.StreamHandler) and handler.stream is before
        ]
        self._lead()

    def stop(self) -> None:
        super().stop()
        self._lead()

    def _lead(self) -> None:
        for handler in self._moved:
            handler.setStream(sys.stderr)


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
    return Bar(*columns, console=console, **options)


def track(items: Iterable[T], what: str, total: int | None = None) -> Iterator[T]:
    """Yield `items` while standard error shows how many are done and how long the rest will take.

    Args:
        items: anything that can be iterated, a generator of parallel results included.
        what: a few words that name the work.
        total: number of items, when `items` has no length.
    """
    total = len(cast(Sized, items)) if total is None else total
    console = Console(stderr=True)
    if console.is_terminal:
        with bar(console) as shown:
            yield from shown.track(items, description=what, total=total)
        return
    if console.is_jupyter:
        shown = NotebookBar(what, total)
        for done, item in enumerate(items, start=1):
            shown.update(done)
            yield item
        return
    start = told = time.monotonic()
    for done, item in enumerate(items, start=1):
        now = time.monotonic()
        if now - told > LINE:
            told = now
            log.info("%s %d/%d, %.0f s left", what, done, total, (now - start) / done * (total - done))
        yield item


class NotebookBar:
    """A bar under the cell that is running, by HTML alone: it needs no widgets.

    Args:
        what: a few words that name the work.
        total: steps until it is done.
    """

    def __init__(self, what: str, total: int):
        self._what, self._total, self._handle = what, total, None
        self._start = self._shown = time.monotonic()

    def update(self, done: int, note: str = "") -> None:
        """So many are done; `note` stands behind."""
        now = time.monotonic()
        if now - self._shown < FRAME and (done < self._total or self._handle is None):
            return
        self._shown = now
        from IPython.display import HTML, display  # a notebook has it

        left = duration((now - self._start) / done * (self._total - done))
        text = f"{self._what} {done}/{self._total}, {left} left {note}" if done < self._total else f"{self._what} done"
        state = HTML(f'<progress value="{done}" max="{self._total}"></progress> {escape(text)}')
        if self._handle is None:
            self._handle = display(state, display_id=True)
        else:
            self._handle.update(state)


def duration(seconds: float) -> str:
    """A time in the unit that suits it, as in 45 s, 6.6 minutes, 3.2 hours."""
    for most, unit, length in ((90, "s", 1), (90, "minutes", 60), (48, "hours", 3600)):
        if seconds < most * length:
            return f"{seconds / length:.2g} {unit}"
    return f"{seconds / 86400:.2g} days"
