"""The house rules: which room may know which, and what a room is free of."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

import lssd_learn

ROOT = Path(lssd_learn.__file__).parent
# Each room knows only those before it.
ORDER = [
    ("errors",), ("progress",), ("cluster",), ("cache",), ("eigensolver",), ("shapes",), ("collections",), ("maps",),
    ("latent",), ("operators",), ("exploration",), ("pipeline",), ("view", "nets"), ("learning",), ("tasks",),
    ("overrides",), ("app",),
]  # fmt: skip
RANK = {room: rank for rank, rooms in enumerate(ORDER) for room in rooms}
FILES = sorted(ROOT.rglob("*.py"))


def imported(file: Path) -> set[str]:
    """Every module that a file names in an import, wherever it stands."""
    names = set()
    for node in ast.walk(ast.parse(file.read_text())):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module == "lssd_learn":
            names |= {f"lssd_learn.{alias.name}" for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            names.add(node.module)
    return names


@pytest.mark.parametrize("file", FILES, ids=lambda f: str(f.relative_to(ROOT)))
def test_imports_point_one_way(file):
    room = file.relative_to(ROOT).parts[0].removesuffix(".py")
    if room == "__init__":
        assert not imported(file) - {"importlib"}
        return
    for name in imported(file):
        if name.startswith("lssd_learn."):
            other = name.split(".")[1]
            assert other == room or RANK[other] < RANK[room], f"{file.relative_to(ROOT)} imports {name}"


def test_only_learning_and_tasks_import_lightning_and_only_the_entry_imports_hydra():
    for file in FILES:
        room = file.relative_to(ROOT).parts[0].removesuffix(".py")
        names = {name.split(".")[0] for name in imported(file)}
        assert "lightning" not in names or room in ("learning", "tasks"), file
        assert not names & {"hydra", "omegaconf"} or room in ("app", "overrides"), file


@pytest.mark.parametrize("room", ["cache", "shapes", "collections", "maps"])
def test_the_geometry_rooms_are_free_of_torch(room):
    code = f"import sys, lssd_learn.{room}; sys.exit('torch' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_the_top_is_lazy_and_every_public_name_is_there():
    code = "import sys, lssd_learn; sys.exit(len([m for m in sys.modules if m.startswith('lssd_learn')]) > 1)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
    for name in lssd_learn.__all__:
        assert getattr(lssd_learn, name) is not None
    with pytest.raises(AttributeError, match="nonsense"):
        lssd_learn.nonsense  # noqa: B018


def test_files_are_short():
    for file in FILES:
        assert len(file.read_text().splitlines()) <= 300, file
