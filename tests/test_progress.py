"""Progress where a person looks: lines in a log, a bar in a notebook."""

import io
import logging
import re
import sys
import types

import pytest
from rich.console import Console

from lssd_learn import progress


@pytest.fixture
def notebook(monkeypatch):
    """A stand-in for IPython's display; the states that were shown."""
    states = []

    class Handle:
        def update(self, state):
            states.append(state)

    def display(state, display_id):
        states.append(state)
        return Handle()

    shown = types.ModuleType("IPython.display")
    shown.HTML, shown.display = str, display
    monkeypatch.setitem(sys.modules, "IPython.display", shown)
    console = types.SimpleNamespace(is_terminal=False, is_jupyter=True)
    monkeypatch.setattr(progress, "Console", lambda **options: console)
    return states


def test_a_notebook_has_a_bar_that_ends_full(notebook, monkeypatch):
    clock = iter(range(100))
    monkeypatch.setattr(progress.time, "monotonic", lambda: float(next(clock)))
    assert list(progress.track("abc", "reading <b>")) == ["a", "b", "c"]
    assert len(notebook) == 3
    assert '<progress value="1" max="3"></progress> reading &lt;b&gt; 1/3' in notebook[0]
    assert notebook[-1].endswith("reading &lt;b&gt; done")


def test_what_is_done_at_once_shows_nothing(notebook):
    assert list(progress.track(range(3), "reading")) == [0, 1, 2]
    assert notebook == []


def test_what_is_logged_meanwhile_stands_above_the_bar(monkeypatch):
    """On a terminal: the bar is taken away, the line is written, and the bar is drawn anew below it."""
    terminal = io.StringIO()
    monkeypatch.setattr(sys, "stderr", terminal)
    handler = logging.StreamHandler()
    monkeypatch.setattr(logging.root, "handlers", [handler])
    console = Console(file=terminal, force_terminal=True, width=80)
    with progress.bar(console) as shown:
        for i in shown.track(range(3), description="reading"):
            logging.getLogger().warning("shape %d is cut", i)
    assert handler.stream is terminal
    lines = re.sub(r"\x1b\[[\d;?]*[a-zA-Z]", "", terminal.getvalue()).replace("\r", "\n").splitlines()
    assert [line for line in lines if "shape" in line] == [f"shape {i} is cut" for i in range(3)]
