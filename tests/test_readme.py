"""What the README and docs/ show is what there is."""

import re
import shlex
from pathlib import Path

import numpy as np

from lssd_learn.app import conf
from lssd_learn.models import Trained
from lssd_learn.overrides import check

ROOT = Path(__file__).parents[1]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]


def blocks(language):
    return re.findall(rf"```{language}\n(.*?)```", "".join(page.read_text() for page in PAGES), re.S)


def test_the_notebook_snippet_runs(tmp_path, monkeypatch):
    monkeypatch.setenv("LSSD_CACHE", str(tmp_path))
    snippet, from_a_checkpoint = blocks("python")
    names = {}
    exec(snippet, names)
    area, conformal = names["area"], names["conformal"]
    assert area.shape == conformal.shape == (40, 20, 20)
    np.testing.assert_allclose(area.mean(0), np.eye(20), atol=1e-10)
    assert names["bend"].shape == (615,)
    assert names["pushed"].area.shape == (20, 20)
    assert names["features"].shape == (1, 420)
    own = names["reader"].matrices([names["new"]])[0]
    np.testing.assert_allclose(own, np.stack([names["pushed"].area, names["pushed"].conformal]), atol=1e-6)
    assert all(callable(getattr(Trained, name)) for name in re.findall(r"model\.(\w+)\(", from_a_checkpoint))


def test_every_command_passes_the_border():
    lines = [line.split("#")[0] for block in blocks("bash") for line in block.splitlines()]
    commands = [part for line in lines for part in line.split("&&") if "train.py" in part]
    assert len(commands) >= 8
    for command in commands:
        check(shlex.split(command)[2:], conf())


def test_the_files_they_name_are_there():
    for page in PAGES:
        text = page.read_text()
        for name in re.findall(r"\]\(((?!http)[^)]+)\)", text):
            assert (page.parent / name).exists(), name
        for table in re.findall(r"`((?:docs/)?results/\w+\.csv)`", text):
            assert (page.parent / table).exists(), table


def test_every_picture_is_shown_somewhere():
    shown = {
        (page.parent / name).resolve()
        for page in PAGES
        for name in re.findall(r"!\[[^]]*\]\(([^)]+)\)", page.read_text())
    }
    pictures = {file.resolve() for kind in ("png", "jpg", "gif", "svg") for file in (ROOT / "docs").rglob(f"*.{kind}")}
    assert pictures == {file for file in shown if file.is_relative_to(ROOT / "docs")}


def test_every_table_of_results_has_its_command():
    rows = re.findall(r"^\| `(\w+\.csv)` \| (.*) \|$", (ROOT / "docs/results/README.md").read_text(), re.M)
    assert sorted(name for name, _ in rows) == sorted(file.name for file in (ROOT / "docs/results").glob("*.csv"))
    for name, how in rows:
        commands = re.findall(r"`(python train\.py [^`]+)`", how)
        assert commands, name
        for command in commands:
            check([part for part in shlex.split(command)[2:] if "…" not in part], conf())
