"""The lesson runs as it stands, draws, and prints what it printed when it was written; exercises have answers."""

import os
import re
from pathlib import Path

import nbformat
import pytest
from nbclient import NotebookClient

LESSON = Path(__file__).parents[1] / "docs" / "lesson.ipynb"
NUMBER = re.compile(r"[-+]?\d+\.?\d*(?:e[-+]\d+)?")


@pytest.fixture(scope="module")
def written():
    return nbformat.read(LESSON, as_version=4)


@pytest.fixture(scope="module")
def ran(tmp_path_factory):
    """The lesson, run anew in an empty folder."""
    folder = tmp_path_factory.mktemp("lesson")
    notebook = nbformat.read(LESSON, as_version=4)
    path = os.pathsep.join([str(LESSON.parents[1]), os.environ.get("PYTHONPATH", "")])
    env = os.environ | {"LSSD_CACHE": str(folder / "cache"), "PYTHONPATH": path, "PYTHONWARNINGS": "default"}
    NotebookClient(notebook, timeout=300, resources={"metadata": {"path": str(folder)}}).execute(env=env)
    return notebook


def printed(cell):
    """What a cell has printed, and the value of its last line where that is no picture."""
    texts = [output.text for output in cell.get("outputs", ()) if output.get("name") == "stdout"]
    data = [output.data for output in cell.get("outputs", ()) if "data" in output]
    return "".join(texts) + "".join(d["text/plain"] for d in data if not {"image/png", "text/html"} & d.keys())


def drawn(cell):
    return sum("image/png" in output.get("data", {}) for output in cell.get("outputs", ()))


def test_it_prints_and_draws_what_the_page_shows(written, ran):
    assert sum(map(drawn, written.cells)) >= 15
    for before, now in zip(written.cells, ran.cells, strict=True):
        old, new = printed(before), printed(now)
        assert NUMBER.sub("#", new) == NUMBER.sub("#", old), before.source
        numbers = [[float(number) for number in NUMBER.findall(text)] for text in (new, old)]
        assert numbers[0] == pytest.approx(numbers[1], rel=0.05, abs=0.02), before.source
        assert drawn(now) == drawn(before)


def test_it_warns_of_nothing(ran):
    outputs = [output for cell in ran.cells for output in cell.get("outputs", ())]
    assert [output.text for output in outputs if output.get("name") == "stderr"] == []


def test_every_exercise_has_its_answer(written):
    text = "\n".join(cell.source for cell in written.cells if cell.cell_type == "markdown")
    asked = re.findall(r"^\*\*Exercise (\d+)\.\*\*", text, re.M)
    assert asked == [str(number) for number in range(1, len(asked) + 1)]
    assert re.findall(r"^\*\*(\d+)\.\*\*", text, re.M) == asked
    assert len(asked) >= 10
