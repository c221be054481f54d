"""The guides, walked: every command of a page, and every block of Python, as it stands, in one folder."""

import importlib.util
import os
import re
import shlex
import subprocess
import sys
import time
from pathlib import Path

import pytest

from lssd_learn.collections import Bodies
from lssd_learn.shapes import save

ROOT = Path(__file__).parents[1]
BLOCK = re.compile(r"^```(bash|python)\n(.*?)^```", re.S | re.M)
INSTALLS = ("python -m venv", "source", "pip", "xdg-open")  # tests of the wheel do that
LEFT = {
    "scans": ["looked/collection.png", "compared/report.html"],
}


def steps(page):
    """(language, a command or a block) in the order of the page, but what makes the folder of the shapes first."""
    found = []
    for language, block in BLOCK.findall((ROOT / "docs" / "guides" / f"{page}.md").read_text(encoding="utf-8")):
        lines = block.replace("\\\n", " ").splitlines() if language == "bash" else [block]
        found += [(language, line.partition(" #")[0] if language == "bash" else line) for line in lines]
    return sorted(found, key=lambda step: "mkdir" not in step[1])


@pytest.mark.slow
@pytest.mark.parametrize("page", LEFT)
def test_a_guide_can_be_walked(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("new_shapes").mkdir()
    others = Bodies(n=3, seed=1, topology="notoes_collapse5pc")
    for i, name in enumerate(others.names):
        save(others[i], Path("new_shapes") / f"{name}.ply")
    names = {"__name__": "page"}
    env = os.environ | {"PYTHONPATH": os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")])}
    for language, step in steps(page):
        begin = time.perf_counter()
        if language == "python":
            exec(compile(step, page, "exec"), names)
        elif not step.startswith(INSTALLS):
            if "task.interactive=true" in step and importlib.util.find_spec("polyscope") is None:
                continue
            program, *arguments = shlex.split(step)
            assert program == "lssd"
            line = [sys.executable, "-m", "lssd_learn", *arguments]
            done = subprocess.run(line, env=env, capture_output=True, text=True, check=False)
            assert done.returncode == 0, done.stderr
        print(f"{time.perf_counter() - begin:6.1f} s  {step.splitlines()[0]}")
    for name in LEFT[page]:
        assert Path(name).stat().st_size > 0
