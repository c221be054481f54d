"""What the pages show runs: every block of Python on tiny bodies, page by page; the formulas; the list of pages."""

import json
import os
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest
import yaml

import lssd_learn

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs"
PAGES = sorted(path.relative_to(DOCS).as_posix() for path in DOCS.rglob("*.md"))
BLOCK = re.compile(r"^```python\n(.*?)^```", re.S | re.M)

# Pages whose Python is run, or looked at, by another test.
ELSEWHERE = {
    "formats.md": "tests/test_readme.py",
    "landmarks.md": "tests/test_readme.py",
    "operators.md": "tests/test_readme.py",
}


def python(page):
    return BLOCK.findall((DOCS / page).read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def place(pieces_of, tmp_path_factory, common_cache):
    """A folder with what commands of the pages leave: a net that has learnt a little, and one that draws."""
    folder = tmp_path_factory.mktemp("docs")
    small = ("collection=bodies_small", "collection.n=24", "basis.k=24", "latent.size=20", "latent.keep=16")
    small += ("task.epochs=1", f"cache={common_cache}")
    for name, more in (("trained", ["net=mlp"]), ("drawn", ["task=reconstruction", "net=vertices", "task.points=64"])):
        pieces = pieces_of(folder / name, *more, *small)
        pieces.task(pieces, folder / name)
    return folder


def shapes_of(names):
    """What the blocks of a page have left, as far as a wrong one would show."""
    return {name: np.shape(value) for name, value in names.items() if hasattr(value, "shape")}


LEFT = {
    "guides/scans.md": {"field": (615,), "area": (16, 20, 20)},
    "guides/train.md": {"errors": (3,)},
    "guides/draw.md": {"area": (4, 12, 12), "answer": (12, 12)},
    "reference/index.md": {"operators": (4, 1, 4, 4)},
    "extend.md": {"predicted": (8, 2)},
}


@pytest.mark.parametrize("page", [page for page in PAGES if python(page) and page not in ELSEWHERE])
def test_every_block_of_python_runs(page, place, common_cache, monkeypatch):
    monkeypatch.chdir(place)
    monkeypatch.setenv("LSSD_CACHE", str(common_cache))
    from lssd_learn.latent.differences import DIFFERENCES

    before, names = dict(DIFFERENCES), {"__name__": "page"}
    try:
        for block in python(page):
            exec(compile(block, page, "exec"), names)
    finally:
        DIFFERENCES.clear()
        DIFFERENCES.update(before)
    assert LEFT.get(page, {}).items() <= shapes_of(names).items()


def test_the_block_of_the_readme_on_a_checkpoint_runs(place, common_cache, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("LSSD_CACHE", str(common_cache))
    shutil.copy(place / "trained" / "best.ckpt", "best.ckpt")
    Path("new").mkdir()
    bodies = lssd_learn.collections.Bodies(n=2, seed=1, topology="notoes_collapse5pc")
    for body, name in zip(bodies, "ab", strict=True):
        lssd_learn.save(body, Path("new") / f"{name}.ply")
    (block,) = (block for block in BLOCK.findall((ROOT / "README.md").read_text("utf-8")) if "best.ckpt" in block)
    names = {"lssd": lssd_learn}
    exec(block, names)
    assert names["model"].predict(["new/a.ply"]).shape == (1, 12)


def test_the_yamls_of_the_page_on_additions_name_what_it_defines():
    text = (DOCS / "extend.md").read_text(encoding="utf-8")
    defined = set(re.findall(r"^(?:class|def) (\w+)", "".join(python("extend.md")), re.M))
    targets = [yaml.safe_load(block)["_target_"] for block in re.findall(r"^```yaml\n(.*?)^```", text, re.S | re.M)]
    assert len(targets) >= 5
    assert {target.removeprefix("theirs.") for target in targets} <= defined


def test_what_the_page_on_additions_shows_is_a_package_that_works(processes, tmp_path):
    text = (DOCS / "extend.md").read_text(encoding="utf-8")
    files = {"theirs/__init__.py": "\n".join(python("extend.md")[:-1])}  # the last is for a notebook
    for name, content in re.findall(r"^```yaml\n# ([\w/]+\.yaml)\n(.*?)^```", text, re.S | re.M):
        files[name] = content
    (entry,) = re.findall(r"^```toml\n(.*?)^```", text, re.S | re.M)
    ((group, plugins),) = tomllib.loads(entry)["project"]["entry-points"].items()
    files["theirs-1.dist-info/METADATA"] = "Metadata-Version: 2.1\nName: theirs\nVersion: 1\n"
    listed = "\n".join(f"{name} = {module}" for name, module in plugins.items())
    files["theirs-1.dist-info/entry_points.txt"] = f"[{group}]\n{listed}\n"
    for name, content in files.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(content, encoding="utf-8")
    path = os.pathsep.join([str(tmp_path), *filter(None, [os.environ.get("PYTHONPATH")])])
    env = os.environ | {"PYTHONPATH": path, "LSSD_CACHE": str(tmp_path / "cache"), "OMP_NUM_THREADS": "1"}
    line = "task=spread collection=eggs network=ring maps=nearest_points latent.operators=[area,bends] net=plain"
    small = "basis.k=16 latent.size=12 latent.keep=8 parallel.workers=1"
    done = processes.run([str(ROOT / "train.py"), *line.split(), *small.split(), "hydra.run.dir=ran"], tmp_path, env)
    assert done.returncode == 0, done.stderr
    assert done.stdout == f"{tmp_path / 'ran'}\n"  # for a script
    assert json.loads((tmp_path / "ran" / "metrics.json").read_text())["spread"] > 0


def test_every_page_is_in_the_list_and_every_entry_is_a_page():
    listed = re.findall(r": ([\w/]+\.md)$", (ROOT / "mkdocs.yml").read_text(encoding="utf-8"), re.M)
    made = {"commands.md", "changes.md", "contributing.md", "lesson.md"}
    assert sorted(set(listed) - made) == PAGES
    assert made <= set(listed)


def test_the_site_is_built_without_a_warning(tmp_path):
    pytest.importorskip("mkdocs")
    program = [sys.executable, "-m", "mkdocs", "build", "--strict", "--quiet", "--site-dir", str(tmp_path / "site")]
    done = subprocess.run(program, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert "<math" in (tmp_path / "site" / "mathematics.html").read_text(encoding="utf-8")
    reference = (tmp_path / "site" / "reference" / "shapes.html").read_text(encoding="utf-8")
    assert 'id="lssd_learn.shapes.eigenbasis.eigenbasis"' in reference
    loaded = [
        address
        for page in (tmp_path / "site").rglob("*.html")
        for address in re.findall(r"<(?:script|link|img)[^>]+(?:src|href)=\"(https?://[^\"]+)", page.read_text("utf-8"))
    ]
    assert not loaded  # from elsewhere
    shutil.rmtree(tmp_path / "site")
