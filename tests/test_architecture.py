"""The house rules: which room may know which, and what a room is free of."""

import ast
import runpy
import subprocess
import sys
from pathlib import Path

import pytest

import lssd_learn

ROOT = Path(lssd_learn.__file__).parent
# Each room knows only those before it.
ORDER = [
    ("errors",), ("written",), ("plugins",), ("partials",), ("progress",), ("cluster",), ("cache",), ("eigensolver",),
    ("kdtree",), ("shapes",), ("collections",), ("maps",), ("latent",), ("differentiable",), ("operators",),
    ("exploration",), ("trusting",), ("pipeline",), ("pushing",), ("estimator",), ("view", "nets"),
    ("sweeps",), ("division",), ("learning",), ("models",), ("mapped",), ("jupyter",), ("pieces",), ("twins",),
    ("unsaid",), ("tasks",), ("measures",), ("studies",), ("command",), ("app",), ("__main__",),
]  # fmt: skip
RANK = {room: rank for rank, rooms in enumerate(ORDER) for room in rooms}
FILES = sorted(ROOT.rglob("*.py"))
TRAINS = ("learning", "tasks", "measures", "studies")  # rooms that may import Lightning


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
        assert not imported(file) - {"importlib", "sys"}
        return
    for name in imported(file):
        if name.startswith("lssd_learn."):
            other = name.split(".")[1]
            assert other == room or RANK[other] < RANK[room], f"{file.relative_to(ROOT)} imports {name}"


def test_only_learning_and_tasks_import_lightning_and_only_the_entry_imports_hydra():
    for file in FILES:
        room = file.relative_to(ROOT).parts[0].removesuffix(".py")
        names = {name.split(".")[0] for name in imported(file)}
        assert "lightning" not in names or room in TRAINS, file
        assert not names & {"hydra", "omegaconf"} or room in ("app", "command"), file


def module(file: Path) -> str:
    """The name of a file's module."""
    return ".".join(("lssd_learn", *file.relative_to(ROOT).with_suffix("").parts)).removesuffix(".__init__")


def reached(file: Path) -> set[Path]:
    """The files of the package that a file imports, wherever it does: a module, or a name out of one."""
    found = set()
    for node in ast.walk(ast.parse(file.read_text())):
        names = [alias.name for alias in node.names] if isinstance(node, ast.Import | ast.ImportFrom) else []
        if isinstance(node, ast.ImportFrom):
            names = [f"{node.module}.{name}" for name in names] + [node.module]
        for name in names:
            found |= {BY_MODULE[name]} if name in BY_MODULE else set()
    return found - {file}


BY_MODULE = {module(file): file for file in FILES}


def test_a_command_that_trains_nothing_does_not_wait_for_lightning():
    """Not the program, nor the tasks that work on operators, nor anything they import: two seconds of a command."""
    waiting = [ROOT / "app.py"]
    waiting += [ROOT / "tasks" / f"{name}.py" for name in ("align", "compare", "embed", "operators", "summary")]
    known = set()
    while waiting:
        file = waiting.pop()
        known.add(file)
        rooms = {folder / "__init__.py" for folder in file.parents if folder.is_relative_to(ROOT)}
        waiting += (reached(file) | rooms) - known
        assert not any(name.startswith("lightning") for name in imported(file)), file
    assert len(known) > 100


def circles(imports: dict) -> list[list]:
    """The groups of two or more that reach each other."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    names = list(imports)
    edges = [(names.index(a), names.index(b)) for a, others in imports.items() for b in others]
    rows, columns = zip(*edges, strict=True)
    graph = coo_array(([1] * len(edges), (rows, columns)), shape=(len(names), len(names)))
    labels = connected_components(graph, directed=True, connection="strong")[1]
    groups = [[name for name, label in zip(names, labels, strict=True) if label == one] for one in set(labels)]
    return [group for group in groups if len(group) > 1]


def test_no_two_files_import_each_other_not_even_by_way_of_others():
    rooms = {file for file in FILES if file.name == "__init__.py"}  # a room names what it holds
    files = {str(file.relative_to(ROOT)): file for file in FILES if file not in rooms}
    imports = {name: {str(other.relative_to(ROOT)) for other in reached(file) - rooms} for name, file in files.items()}
    assert circles(imports) == []


def test_no_file_takes_a_name_from_its_own_room():
    for file in FILES:
        room = module(file.parent / "__init__.py")
        if file.name == "__init__.py" or room == "lssd_learn":
            continue
        for node in ast.walk(ast.parse(file.read_text())):
            if isinstance(node, ast.ImportFrom) and node.module == room:
                assert all(f"{room}.{alias.name}" in BY_MODULE for alias in node.names), file


def test_a_circle_is_found():
    assert circles({"a": {"b"}, "b": {"c"}, "c": {"a"}, "d": {"a"}}) == [["a", "b", "c"]]


def test_a_room_is_no_warehouse():
    for folder in {file.parent for file in FILES}:
        files = [file for file in folder.glob("*.py") if file.name != "__init__.py"]
        assert len(files) <= 20, f"{folder.relative_to(ROOT)} has {len(files)} files: it is two rooms"
    tasks = sum(len(file.read_text().splitlines()) for file in (ROOT / "tasks").rglob("*.py"))
    assert tasks < 2000


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


def test_the_page_on_architecture_is_short_and_its_picture_has_every_room():
    docs = ROOT.parent / "docs"
    assert len((docs / "architecture.md").read_text().splitlines()) <= 80
    levels = runpy.run_path(str(docs / "rooms.py"))["LEVELS"]
    drawn = {name for level in levels for name in level}
    assert {folder.name for folder in ROOT.iterdir() if (folder / "__init__.py").is_file()} <= drawn
