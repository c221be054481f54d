"""How to go on after Ctrl-C. Used by `app.py`."""

import shlex
import sys
from collections.abc import Sequence
from pathlib import Path

from lssd_learn.command.folders import quoted

LAST = "last.ckpt"


def how_to_go_on(given: Sequence[str], begin: float, places: Sequence[Path], sweeps: bool) -> str:
    """The command that goes on with what was interrupted, in words.

    Args:
        given: the arguments as typed.
        begin: the time at which the program began.
        places: the folder of the run or sweep; none where it had not begun.
        sweeps: whether it was a sweep.
    """
    line, more = list(given), "what was computed is in the cache"
    if places and sweeps:
        line, more = _without(line, "hydra.sweep.dir"), "jobs that are done are kept"
        line.append(f"hydra.sweep.dir={quoted(str(places[0]))}")
    elif places:
        last = places[0] / LAST
        if last.is_file() and ("ckpt_path=last" in given or last.stat().st_mtime >= begin):
            line, more = _without(line, "hydra.run.dir", "ckpt_path"), "training goes on from its last checkpoint"
            line += [f"hydra.run.dir={quoted(str(places[0]))}", "ckpt_path=last"]
    return f"to go on ({more}): {shlex.join([*_program(), *line])}"


def _without(arguments: Sequence[str], *keys: str) -> list[str]:
    return [a for a in arguments if a.lstrip("+").partition("=")[0] not in keys]


def _program() -> list[str]:
    """The program as it was called."""
    name = Path(sys.argv[0]).name
    if name == "__main__.py":
        return ["python", "-m", "lssd_learn"]
    return ["python", sys.argv[0]] if name.endswith(".py") else [name]
