"""The Hydra entry, shared by train.py and the console script `lssd`: compose the configuration, run the task it names.

What comes from the command line is checked here; a mistake anywhere ends in one line and exit status 1. After a run its
directory holds metrics.json and provenance.json beside what the task made.
"""

import json
import logging
import os
import shlex
import subprocess
import sys
from importlib.metadata import version
from pathlib import Path

import hydra
from hydra.core.hydra_config import HydraConfig
from hydra.errors import HydraException, InstantiationException
from omegaconf import DictConfig, OmegaConf
from omegaconf.errors import OmegaConfBaseException

from lssd_learn.errors import InputError
from lssd_learn.overrides import check, explain
from lssd_learn.tasks.pieces import Pieces

log = logging.getLogger(__name__)

_failures: list[Exception] = []  # of this process's jobs

PACKAGES = ("lssd_learn", "anny", "lightning", "numpy", "scipy", "torch", "trimesh")


def main() -> None:
    """Run the command line; errors of the user end in one line on standard error and exit status 1."""
    os.environ["HYDRA_FULL_ERROR"] = "1"  # Hydra then raises instead of printing its own account of the error
    try:
        check(sys.argv[1:], conf())
        hydra.main(version_base="1.3", config_path=str(conf()), config_name="config")(job)()
    except InstantiationException:
        raise  # ours, not the user's: `job` has told the others apart
    except (InputError, HydraException, OmegaConfBaseException) as error:
        _fail(explain(error))
    except KeyboardInterrupt:
        _fail("interrupted")
    if _failures:
        sys.exit(1)


def conf() -> Path:
    """The folder of the configuration: inside the installed package, or beside it in a checkout."""
    installed = Path(__file__).parent / "conf"
    return installed if installed.is_dir() else Path(__file__).parents[1] / "conf"


def job(cfg: DictConfig) -> float | None:
    """One job. A mistake of the user is said in one line and remembered; the other jobs of a sweep go on."""
    try:
        return run(cfg)
    except (InputError, InstantiationException, OmegaConfBaseException) as error:
        if isinstance(error, InstantiationException) and not isinstance(error.__cause__, InputError):
            raise  # a fault of the program keeps its traceback
        log.error("error: %s", explain(error))
        _failures.append(error)
        return None


def run(cfg: DictConfig) -> float | None:
    """Instantiate the pieces, run the task, leave its metrics. Returns what a sweeper minimises."""
    leads = os.environ.get("LOCAL_RANK", "0") == "0"  # the other processes of a distributed run repeat all this
    if not leads:
        logging.disable(logging.WARNING)
    out = Path(HydraConfig.get().runtime.output_dir)
    config = OmegaConf.to_container(cfg, resolve=True, throw_on_missing=True)
    choices = dict(HydraConfig.get().runtime.choices)
    pieces = Pieces.from_config(config, choices, hydra.utils.instantiate, out, _command(task="operators"))
    metrics = pieces.task(pieces, out)
    if not leads:
        return None
    _write(out / "metrics.json", {name: value for name, value in metrics.items() if value is not None})
    _write(out / "provenance.json", _provenance(pieces))
    log.info("everything is in %s", out)
    return metrics.get("validation/mse", metrics.get("validation/error"))


def _provenance(pieces: Pieces) -> dict:
    """What it takes to run this again: code, versions, and what the cache knows the inputs by."""
    here = Path(__file__).parent
    git = subprocess.run(["git", "rev-parse", "HEAD"], cwd=here, capture_output=True, text=True, check=False)
    return {
        "command": _command(),
        "commit": git.stdout.strip() or None,
        "python": sys.version.split()[0],
        "packages": {name: version(name) for name in PACKAGES},
        "cache": str(pieces.pipeline.cache.root),
        "keys": pieces.pipeline.keys,
    }


def _command(task: str | None = None) -> str:
    """The command line of this job, for another task where one is named."""
    overrides = list(HydraConfig.get().overrides.task)
    if task is not None:
        own = ("task", "net", "data", "ckpt_path")  # what another task has no use for
        overrides = [o for o in overrides if o.split("=")[0].split(".")[0] not in own] + [f"task={task}"]
    return shlex.join(["python", "train.py", *overrides])


def _write(path: Path, content: dict) -> None:
    path.write_text(json.dumps(content, indent=1) + "\n")


def _fail(message: str) -> None:
    print(f"error: {message}", file=sys.stderr)
    sys.exit(1)
