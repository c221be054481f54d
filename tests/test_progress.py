"""Progress where a person looks: lines in a log, a bar in a notebook."""

import sys
import types

import pytest

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
