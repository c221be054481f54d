"""Where a run or a sweep will take place, known before Hydra makes the folder. Used by `app.py`."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

from hydra import initialize_config_dir
from hydra._internal.hydra import Hydra
from hydra.core.global_hydra import GlobalHydra
from hydra.core.hydra_config import HydraConfig
from hydra.types import RunMode
from omegaconf import OmegaConf

from lssd_learn.command.searchpath import KEY, named, override

# Options of Hydra with which nothing is run.
LOOKS = ("--help", "-h", "--hydra-help", "--version", "--cfg", "-c", "--info", "-i", "--shell-completion", "-sc")


@dataclass(frozen=True)
class Place:
    """A folder.

    Attributes:
        key: of the configuration: hydra.run.dir or hydra.sweep.dir.
        folder: the path.
        is_new: whether its name is that of the moment, so that no earlier run can be meant.
    """

    key: str
    folder: Path
    is_new: bool


def place(arguments: Sequence[str], conf: Path) -> Place | None:
    """Where a command will be run; None for one that runs nothing.

    Args:
        arguments: of the command line, checked.
        conf: the folder of the configuration.
    """
    options = [a.partition("=")[0] for a in arguments if a.startswith("-")]
    if set(options) & set(LOOKS):
        return None
    overrides = [a for a in arguments if "=" in a and not a.startswith(("-", KEY, f"+{KEY}"))]
    overrides += override(named(arguments))
    with initialize_config_dir(str(conf), version_base="1.3"):
        hydra = cast(Hydra, GlobalHydra.instance().hydra)
        # For several jobs, in which one may be written too; what an experiment says of itself is then known at once.
        cfg = hydra.compose_config(
            "config", overrides, RunMode.MULTIRUN, with_log_configuration=False, validate_sweep_overrides=False
        )
        several = cfg.hydra.mode == RunMode.MULTIRUN or bool({"-m", "--multirun"} & set(options))
        key = "hydra.sweep.dir" if several else "hydra.run.dir"
        node, before = cfg.hydra.sweep if several else cfg.hydra.run, HydraConfig.instance().cfg
        HydraConfig.instance().set_config(cfg)
        try:
            folder = Path(str(node.dir))
        finally:
            HydraConfig.instance().cfg = before
        return Place(key, folder, "${now:" in cast(dict[str, Any], OmegaConf.to_container(node, resolve=False))["dir"])


def quoted(text: str) -> str:
    """A text as Hydra reads it back, with quotes where it wants them."""
    plain = text.replace("/", "").replace("-", "").replace(".", "").replace("_", "")
    if plain.isalnum() and plain.isascii() and not text.replace("_", "").replace(".", "").isnumeric():
        return text
    return "'" + text.replace("\\", "\\\\").replace("'", "\\'") + "'"
