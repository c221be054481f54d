"""The border of the command line: every `group=choice` and `key=value` is checked before anything runs.

Hydra accepts `+key=…` of any spelling and values of any type, and reports a wrong key in five lines without the right
ones. Here a mistake is one line that names what there is. Used by `app.py`.
"""

import itertools
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from hydra import compose, initialize_config_dir
from hydra.core.override_parser.overrides_parser import OverridesParser
from hydra.core.override_parser.types import ChoiceSweep, Override, OverrideType, Sweep, Transformer
from omegaconf import DictConfig, ListConfig, OmegaConf
from omegaconf.errors import MissingMandatoryValue

from lssd_learn.errors import InputError


def check(arguments: Sequence[str], conf: Path) -> None:
    """Refuse unknown groups, choices and keys, added and deleted keys, and values of another type than the default.

    Args:
        arguments: of the command line; options that begin with a dash are Hydra's business.
        conf: the folder of the configuration.

    Raises:
        InputError: names the argument and what it could have been.
    """
    parser = OverridesParser.create()
    parsed = [parser.parse_override(a) for a in arguments if not a.startswith("-") and ("=" in a or a[:1] in "+~")]
    ours = [o for o in parsed if not o.key_or_group.startswith("hydra")]
    groups = [o for o in ours if (conf / o.key_or_group).is_dir() and o.type != OverrideType.DEL]
    for override in groups:
        _check_choice(override, conf)
    choices = [[f"{o.key_or_group}={value}" for value in _values(o)] for o in groups]
    for combination in itertools.product(*choices):
        with initialize_config_dir(str(conf), version_base="1.3"):
            cfg = compose("config", overrides=list(combination))
        for override in ours:
            if override not in groups:
                _check_value(override, cfg)


def explain(error: Exception) -> str:
    """An error of Hydra's or ours in one line."""
    cause: BaseException | None = error
    while cause is not None:
        if isinstance(cause, InputError):
            return str(cause)
        if isinstance(cause, MissingMandatoryValue):
            return f"{cause.full_key}: expected a value, and it has none; give {cause.full_key}=…"
        cause = cause.__cause__
    return " ".join(line.strip() for line in str(error).splitlines()[:2])


def _check_choice(override: Override, conf: Path) -> None:
    group = override.key_or_group
    known = sorted(file.stem for file in (conf / group).glob("*.yaml"))
    for value in _values(override):
        if value not in known:
            raise InputError(f"{group}={value}: expected one of {', '.join(known)}")


def _check_value(override: Override, cfg: DictConfig) -> None:
    key = override.key_or_group
    if override.type == OverrideType.DEL:
        raise InputError(f"{override.input_line}: a key cannot be taken away; set it to another value")
    *path, last = key.split(".")
    node: Any = cfg
    for depth, name in enumerate(path):
        node = node.get(name) if isinstance(node, DictConfig) and name in node else None
        if not isinstance(node, DictConfig):
            raise InputError(
                f"{override.input_line}: there is no {'.'.join(path[: depth + 1])}; there are {_keys(cfg)}"
            )
    if last not in list(node):  # `last in node` is false for a value that is still missing
        where = ".".join(path) or "the configuration"
        raise InputError(f"{override.input_line}: there is no {key}; {where} has {_keys(node)}")
    if override.type == OverrideType.ADD:
        raise InputError(f"{override.input_line}: {key} is there already; leave the + away")
    if isinstance(node[last] if not OmegaConf.is_missing(node, last) else None, DictConfig):
        raise InputError(
            f"{override.input_line}: expected one of its keys, as in {key}.{_keys(node[last]).split(',')[0]}=…"
        )
    if OmegaConf.is_missing(node, last) or OmegaConf.is_interpolation(node, last) or node[last] is None:
        return
    for value in _values(override):
        if not _fits(value, node[last]):
            raise InputError(f"{key}={value}: expected {_kind(node[last])}, as in {key}={_shown(node[last])}")


def _values(override: Override) -> Iterable[Any]:
    """The value, or those a sweep goes through; none of a sweep without a list, such as an interval."""
    if not override.is_sweep_override():
        return [override.value()]
    sweep: Sweep = override.value()
    if isinstance(sweep, ChoiceSweep) or not override.is_interval_sweep():
        return list(override.sweep_iterator(Transformer.identity))
    return []


def _fits(value: Any, default: Any) -> bool:
    if isinstance(value, str) and "${" in value:
        return True
    if isinstance(default, bool) or isinstance(value, bool):
        return isinstance(default, bool) and isinstance(value, bool)
    if isinstance(default, int):
        return isinstance(value, int)
    if isinstance(default, float):
        return isinstance(value, int | float)
    if isinstance(default, ListConfig):
        return isinstance(value, list)
    return not isinstance(value, list | dict)


def _kind(default: Any) -> str:
    kinds = {bool: "true or false", int: "a whole number", float: "a number", ListConfig: "a list"}
    return kinds.get(type(default), "a word")


def _shown(default: Any) -> str:
    if isinstance(default, ListConfig):
        return str(list(default)).replace("'", "").replace(" ", "")
    return str(default).lower() if isinstance(default, bool) else str(default)


def _keys(node: DictConfig) -> str:
    return ", ".join(key for key in node if key not in ("_target_", "_partial_", "hydra"))
