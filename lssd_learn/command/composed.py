"""The configuration that some overrides make, composed once a process. Used by `overrides.py` and `typed.py`."""

from collections.abc import Iterable
from functools import lru_cache
from pathlib import Path

from hydra import compose, initialize_config_dir
from omegaconf import DictConfig


def composed(conf: Path, overrides: Iterable[str]) -> DictConfig:
    """The whole configuration, Hydra's own with it; several who look at the same get the same, so only to be read.

    Args:
        conf: the folder of the configuration.
        overrides: choices, keys, and what adds folders to the search path.

    Raises:
        HydraException: no such choice or key, a plugin that is not installed.
    """
    return _composed(conf, tuple(overrides))


@lru_cache(maxsize=512)
def _composed(conf: Path, overrides: tuple[str, ...]) -> DictConfig:
    with initialize_config_dir(str(conf), version_base="1.3"):
        return compose("config", overrides=list(overrides), return_hydra_config=True)
