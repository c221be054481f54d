"""The Hydra entry, shared by train.py and the console script `lssd`: compose the configuration, run the task it names.

What comes from the command line is checked here; a mistake anywhere ends in one line and exit status 1. After a run its
directory holds metrics.json and provenance.json beside what the task made, or error.txt; a sweep, of whatever launcher,
ends with the summary of its runs.
"""

import errno
import hashlib
import json
import logging
import os
import platform
import shlex
import shutil
import subprocess
import sys
import time
from collections.abc import Sequence
from contextlib import suppress
from importlib.metadata import PackageNotFoundError, version
from multiprocessing import parent_process
from pathlib import Path
from typing import Any, cast

import hydra
import torch
from hydra.core.hydra_config import HydraConfig
from hydra.errors import HydraException, InstantiationException
from hydra.experimental.callback import Callback
from hydra.types import RunMode
from omegaconf import DictConfig, OmegaConf
from omegaconf.errors import OmegaConfBaseException

from lssd_learn.cache import Cache
from lssd_learn.cluster import cluster
from lssd_learn.command.claims import claim, claim_new
from lssd_learn.command.finished import PROVENANCE, finished
from lssd_learn.command.folders import place, quoted
from lssd_learn.command.interrupted import how_to_go_on
from lssd_learn.command.overrides import explain
from lssd_learn.command.sizes import bring_down
from lssd_learn.command.understood import understood
from lssd_learn.command.yamls import conf
from lssd_learn.errors import InputError
from lssd_learn.mapped import leave_qualities
from lssd_learn.pieces import Pieces
from lssd_learn.plugins import plugins, trust
from lssd_learn.sweeps.runs import ERROR, METRICS, read_runs
from lssd_learn.sweeps.summary import write
from lssd_learn.sweeps.table import summarise
from lssd_learn.written import write_rows

log = logging.getLogger(__name__)

_begun: list[DictConfig] = []  # the jobs of this process
_failures: list[Exception] = []  # and what of theirs went wrong
_sweeps: list[Path] = []  # the folders of the sweeps of this process
_places: list[Path] = []  # the folder that it has taken

NO_ROOM = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EROFS)

CHANGES = "aligned.csv"  # what was done to the shapes before anything was computed

INTERRUPTED = 130  # the exit status of what Ctrl-C ended

PACKAGES = ("lssd_learn", "anny", "lightning", "numpy", "scipy", "torch", "trimesh")


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command line; errors of the user end in one line on standard error and exit status 1.

    Args:
        arguments: those of the command line as they were understood; None looks at them now.
    """
    os.environ["HYDRA_FULL_ERROR"] = "1"  # Hydra then raises instead of printing its own account of the error
    begin, given = time.time(), list(sys.argv[1:])
    interrupted = False
    try:
        sys.argv[1:] = understood(given) if arguments is None else arguments
        if _leads():
            sys.argv[1:] = [*sys.argv[1:], *_take_folder(sys.argv[1:])]
        hydra.main(version_base="1.3", config_path=str(conf()), config_name="config")(job)()
    except InstantiationException:
        raise  # ours, not the user's: `job` has told the others apart
    except (InputError, HydraException, OmegaConfBaseException) as error:
        _fail(explain(error))
    except KeyboardInterrupt:
        interrupted = True
    except BrokenPipeError:  # `lssd --cfg job | head` has read enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    except (OSError, ValueError) as error:
        fault = error if isinstance(error, OSError) else error.__cause__  # the log's file is one of them
        if _begun or not isinstance(fault, OSError):
            raise
        _fail(f"{fault.filename}: the folder of the run cannot be written: {fault.strerror}")
    finally:
        failed = [_summarise(folder) for folder in _sweeps]
        for folder in _sweeps:
            _hand_on(folder)
    if interrupted and _leads():
        _fail(f"interrupted; {how_to_go_on(given, begin, _places, bool(_sweeps))}", INTERRUPTED)
    if interrupted:
        sys.exit(INTERRUPTED)
    if _failures or any(failed):
        sys.exit(1)


def _take_folder(arguments: Sequence[str]) -> list[str]:
    """Claim the folder of the run or sweep before anything is written there; the override that leads to it, if new."""
    placed = place(arguments, conf())
    if placed is None:  # nothing is to be run
        return []
    if placed.is_new:
        _places.append(claim_new(placed.folder, placed.key))
        return [f"{placed.key}={quoted(str(_places[-1]))}"]
    claim(placed.folder, placed.key)
    _places.append(placed.folder)
    return []


class SweepFolder(Callback):
    """Remembers where a sweep takes place. Its end is no place to sum it up: Hydra skips that one after a failure."""

    def on_multirun_start(self, config: DictConfig, **kwargs) -> None:
        _sweeps.append(Path(config.hydra.sweep.dir))


def job(cfg: DictConfig) -> float | None:
    """One job. What goes wrong is said and remembered, in error.txt too: a launcher's processes share only files.
    The other jobs of a sweep go on."""
    _begun.append(cfg)
    out = Path(HydraConfig.get().runtime.output_dir)
    if _leads():
        try:
            claim(out, "hydra.sweep.dir" if _is_sweep() else "hydra.run.dir")
        except InputError as error:  # and nothing is written there
            _failures.append(error)
            log.error("error: %s", error)
            return None
        if _is_sweep() and (kept := finished(out, HydraConfig.get().overrides.task)) is not None:
            return _score(kept)
        (out / ERROR).unlink(missing_ok=True)  # of an earlier run in the same folder
    try:
        return run(cfg)
    except KeyboardInterrupt:
        if parent_process() is None:
            raise
        os._exit(INTERRUPTED)  # of a launcher's process; the first one says it
    except Exception as error:
        _failures.append(error)
        cause = error.__cause__ if isinstance(error, InstantiationException) and error.__cause__ else error
        if isinstance(cause, InputError | OmegaConfBaseException | InstantiationException):
            line = explain(error)
            log.error("error: %s", line)
        elif isinstance(cause, OSError) and cause.errno in NO_ROOM:
            line = f"{out}: the folder of the run cannot be written: {cause.strerror}"
            log.error("error: %s", line)
        else:  # a fault of the program keeps its traceback
            line = f"{type(cause).__name__}: {cause}".splitlines()[0]
            log.exception("error: %s", line)
        if _leads():
            with suppress(OSError):  # there may be no room for it either
                (out / ERROR).write_text(line + "\n", encoding="utf-8")
        return None


def run(cfg: DictConfig) -> float | None:
    """Instantiate the pieces, run the task, leave its metrics. Returns what a sweeper minimises."""
    if not _leads():
        logging.disable(logging.WARNING)
    out = Path(HydraConfig.get().runtime.output_dir)
    plugins()  # a launcher's process has not met them
    config = cast(dict[str, Any], OmegaConf.to_container(cfg, resolve=True, throw_on_missing=True))
    typed = list(HydraConfig.get().overrides.task)
    if line := bring_down(config, typed):
        log.info("%s", line)
    if _is_sweep() and config["ckpt_path"] == "last" and not (out / "last.ckpt").is_file():
        config["ckpt_path"] = None  # a job of a sweep that had not come so far
    trust(config)
    choices = dict(HydraConfig.get().runtime.choices)
    pieces = Pieces.from_config(config, choices, hydra.utils.instantiate, out, _command(task="operators"))
    if _leads():
        (out / METRICS).unlink(missing_ok=True)  # as long as this run has none, the folder has none
    checkpoint = None if pieces.ckpt_path is None else _sha256(pieces.ckpt_path)  # the run may write over it
    with cluster(config["parallel"]["backend"], config["parallel"]["address"]):
        metrics = pieces.task(pieces, out)
    if not _leads():
        return None
    if changes := pieces.pipeline.collection.changes():
        write_rows(changes, out / CHANGES)
        log.info("how every shape was turned: %s", out / CHANGES)
    leave_qualities(pieces.pipeline, out)
    if config["collection"].get("up", "") is None and any(out.glob("*.png")):
        log.info("in pictures y points up; collection.up=z where it is z")
    if (board := out / "tensorboard").is_dir():
        from lssd_learn.view.board import write_command  # of the runs that have a page, which have imported it

        write_command(board, _command())
    _write(out / PROVENANCE, _provenance(pieces, checkpoint))
    _write(out / METRICS, {name: value for name, value in metrics.items() if value is not None})
    log.info("everything is in %s", out)
    if not _is_sweep():
        _hand_on(out)
    return _score(metrics)


def _hand_on(folder: Path) -> None:
    """Where a run or a sweep has left everything, to a program that reads standard output; the log is for people."""
    if not sys.stdout.isatty():
        sys.stdout.write(f"{folder.absolute()}\n")


def _score(metrics: dict[str, float]) -> float | None:
    """The first score on validation: the one that the epoch was chosen by."""
    return next((value for name, value in metrics.items() if name.startswith("validation/")), None)


def _is_sweep() -> bool:
    return HydraConfig.get().mode == RunMode.MULTIRUN


def _leads() -> bool:
    """Whether this is the first process of a distributed run; the others repeat all it does."""
    return all(os.environ.get(rank, "0") == "0" for rank in ("LOCAL_RANK", "NODE_RANK", "GROUP_RANK", "SLURM_NODEID"))


def _summarise(folder: Path) -> bool:
    """Write the summary of a sweep; whether any of its runs failed."""
    try:
        table = summarise(read_runs(folder))
    except InputError:  # it ended before its first run, and has said why
        return False
    write(table, folder)
    return bool(table.failed)


def _provenance(pieces: Pieces, checkpoint: str | None) -> dict:
    """What it takes to run this again: code, versions, where it ran, and what the inputs are known by."""
    return {
        "command": _command(),
        "directory": os.getcwd(),
        "commit": _git("rev-parse", "HEAD"),
        "modified": bool(_git("status", "--porcelain", "--untracked-files=no")),
        "python": sys.version.split()[0],
        "platform": platform.platform(),
        "threads": torch.get_num_threads(),
        "packages": {name: _version(name) for name in PACKAGES}
        | {plugin.distribution: plugin.version for plugin in plugins() if plugin.distribution},
        "cache": str(cast(Cache, pieces.pipeline.cache).root),
        "keys": pieces.pipeline.keys,
        "ckpt_sha256": checkpoint,
    }


def _version(name: str) -> str | None:
    """Of a package; None of an extra that is not installed."""
    try:
        return version(name)
    except PackageNotFoundError:
        return None


def _sha256(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _git(*arguments: str) -> str | None:
    """What git says of this checkout; None where this is none, or no git."""
    if shutil.which("git") is None:
        return None
    here = Path(__file__).parent
    done = subprocess.run(["git", *arguments], cwd=here, capture_output=True, text=True, check=False)
    return done.stdout.strip() or None


def _command(task: str | None = None) -> str:
    """The command line of this job, for another task where one is named."""
    overrides = list(HydraConfig.get().overrides.task)
    if task is not None:
        own = ("task", "net", "data", "ckpt_path")  # what another task has no use for
        overrides = [o for o in overrides if o.split("=")[0].split(".")[0] not in own] + [f"task={task}"]
    program = ["python", "train.py"] if Path(sys.argv[0]).name == "train.py" else ["lssd"]
    return shlex.join([*program, *overrides])


def _write(path: Path, content: dict) -> None:
    path.write_text(json.dumps(content, indent=1) + "\n")


def _fail(message: str, status: int = 1) -> None:
    print(f"error: {message}", file=sys.stderr)
    sys.exit(status)
