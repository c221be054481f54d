"""The runs in a folder, as they were left there: what each was asked for, what it measured, why it failed.

Whatever made the runs, one process or many, this reads only files, so a sweep can be summed up at any time.
"""

import json
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import yaml

from lssd_learn.errors import InputError

METRICS, ERROR = "metrics.json", "error.txt"
UNFINISHED = "no metrics: killed, or not at its end yet"


@dataclass(frozen=True)
class Run:
    """One run.

    Attributes:
        name: its folder, relative to the one searched.
        overrides: key → value, as typed on the command line.
        metrics: name → number; empty where it failed.
        error: the line that says why it failed, None where it did not.
    """

    name: str
    overrides: dict[str, str]
    metrics: dict[str, float]
    error: str | None

    @property
    def title(self) -> str:
        """The folder and what was asked for, on one line."""
        return " ".join([self.name, *(f"{key}={value}" for key, value in self.overrides.items())])


def read_runs(folder: str | Path) -> list[Run]:
    """Every run below a folder, 2 before 10; those of task=summary are left out.

    Raises:
        InputError: no folder, or none of a run in it.
    """
    folder = Path(folder)
    if not folder.is_dir():
        raise InputError(f"{folder}: expected the folder of a sweep, but there is none")
    found = sorted((path.parents[1] for path in folder.rglob(".hydra/overrides.yaml")), key=_natural)
    runs = [_read(path, folder) for path in found]
    runs = [run for run in runs if run.overrides.get("task") != "summary"]
    if not runs:
        raise InputError(f"{folder}: expected the folder of a sweep, but it holds no runs (with .hydra/overrides.yaml)")
    return runs


def differing(runs: Sequence[Run], but: Sequence[str] = ("seed",)) -> list[str]:
    """The keys of which the runs have different values, in the order they were typed; those in `but` left out."""
    keys = dict.fromkeys(key for run in runs for key in run.overrides)
    return [key for key in keys if key not in but and len({run.overrides.get(key) for run in runs}) > 1]


def _natural(path: Path) -> list:
    return [[(not part.isdigit(), int(part) if part.isdigit() else part) for part in re.findall(r"\d+|\D+", name)]
        for name in path.parts]  # fmt: skip


def _read(path: Path, folder: Path) -> Run:
    overrides = _overrides(path / ".hydra" / "overrides.yaml")
    name = str(path.relative_to(folder))
    if (path / ERROR).is_file():
        return Run(name, overrides, {}, (path / ERROR).read_text(encoding="utf-8").strip() or "failed")
    if not (path / METRICS).is_file():
        return Run(name, overrides, {}, UNFINISHED)
    try:
        metrics = json.loads((path / METRICS).read_text(encoding="utf-8"))
        return Run(name, overrides, {str(key): float(value) for key, value in metrics.items()}, None)
    except (ValueError, TypeError, AttributeError):
        return Run(name, overrides, {}, f"{METRICS} is damaged: expected a number for each name")


def _overrides(path: Path) -> dict[str, str]:
    """Without `ckpt_path=last`: going on ends as an uninterrupted run does."""
    try:
        lines = yaml.safe_load(path.read_text(encoding="utf-8")) or []
        pairs = [str(line).lstrip("+").partition("=")[::2] for line in lines]
    except (yaml.YAMLError, TypeError) as error:
        raise InputError(f"{path}: expected a list of key=value: {str(error).splitlines()[0]}") from error
    return {key: value for key, value in pairs if (key, value) != ("ckpt_path", "last")}
