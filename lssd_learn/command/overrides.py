"""The border of the command line: every `group=choice` and `key=value` is checked before anything runs.

Hydra accepts `+key=…` of any spelling and values of any type, and reports a wrong key in five lines without the right
ones. Here a mistake is one line that names what there is. Used by `app.py`.
"""

import difflib
import inspect
import itertools
import re
from collections.abc import Iterable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, get_args

from hydra.core.override_parser.overrides_parser import OverridesParser
from hydra.core.override_parser.types import ChoiceSweep, Override, OverrideType, Transformer
from hydra.errors import HydraException, MissingConfigException
from hydra.types import RunMode
from hydra.utils import get_object
from omegaconf import DictConfig, ListConfig, OmegaConf
from omegaconf.errors import MissingMandatoryValue, OmegaConfBaseException

from lssd_learn.command.composed import composed
from lssd_learn.command.searchpath import folders, named
from lssd_learn.command.searchpath import override as searchpath
from lssd_learn.command.yamls import groups as choices_of
from lssd_learn.errors import InputError

OPTIONS_WITH_A_VALUE = ("--cfg", "-c", "--package", "-p", "--config-path", "-cp", "--config-name", "-cn",
    "--config-dir", "-cd", "--experimental-rerun", "--info", "-i")  # fmt: skip

EXTRAS = ("joblib", "submitit", "ray", "optuna")  # of the package, each with a launcher or sweeper in it


def check(arguments: Sequence[str], conf: Path) -> None:
    """Refuse what is no override, unknown groups, choices and keys, added and deleted keys, and values of another type
    than the default.

    Args:
        arguments: of the command line; options that begin with a dash are Hydra's business.
        conf: the folder of the configuration; plug-ins and options add others.

    Raises:
        InputError: names the argument and what it could have been.
    """
    parser = OverridesParser.create()
    options = [a for a in arguments if a.startswith("-")]
    values = [a for option, a in zip(arguments, arguments[1:], strict=False) if option in OPTIONS_WITH_A_VALUE]
    parsed = [_parse(a, parser) for a in arguments if a not in options and (is_override(a) or a not in values)]
    ours = [o for o in parsed if not o.key_or_group.startswith("hydra")]
    places = folders(conf, arguments)
    groups = [o for o in ours if _is_group(o.key_or_group, places) and o.type != OverrideType.DEL]
    for override in groups:
        _check_choice(override, places)
    choices = [[f"{o.key_or_group}={value}" for value in _values(o)] for o in groups]
    sweeps = bool({"-m", "--multirun"} & set(options)) or any(o.key_or_group == "hydra.mode" for o in parsed)
    also = searchpath(named(arguments))
    for chosen in itertools.product(*choices):
        combination = [*chosen, *also]
        cfg = composed(conf, combination)
        sweeps = sweeps or cfg.hydra.mode == RunMode.MULTIRUN  # an experiment's own
        if swept := _swept_groups(cfg, places, combination, parser):
            cfg = composed(conf, [*combination, *swept])
        for override in ours:
            if override not in groups:
                _check_value(override, cfg, conf)
    if not sweeps:
        _check_single(parsed)


def _swept_groups(cfg: DictConfig, places: Sequence[Path], given: Iterable[str], parser: OverridesParser) -> list[str]:
    """The first choice of each group that an experiment sweeps over by itself: keys of these choices are right too."""
    typed = {choice.partition("=")[0] for choice in given}
    params = {key: value for key, value in (cfg.hydra.sweeper.get("params") or {}).items() if _is_group(key, places)}
    overrides = [parser.parse_override(f"{key}={value}") for key, value in params.items() if key not in typed]
    return [f"{o.key_or_group}={next(iter(_values(o)))}" for o in overrides]


def is_override(argument: str) -> bool:
    """Whether an argument says `key=value`, `+key=value` or `~key`, and is no option and no option's value."""
    return not argument.startswith("-") and ("=" in argument or argument.startswith(("+", "~")))


def explain(error: Exception) -> str:
    """An error of Hydra's or ours in one line."""
    cause: BaseException | None = error
    while cause is not None:
        if isinstance(cause, InputError):
            return str(cause)
        if isinstance(cause, MissingMandatoryValue):
            return f"{cause.full_key}: expected a value, and it has none; give {cause.full_key}=…"
        cause = cause.__cause__
    if isinstance(error, MissingConfigException) and str(error.missing_cfg_file).startswith("hydra/"):
        extra = Path(str(error.missing_cfg_file)).name.split("_")[0]
        if extra in EXTRAS:
            return f"{error.missing_cfg_file} is a plugin of Hydra and not installed: pip install 'lssd_learn[{extra}]'"
    if isinstance(error, OmegaConfBaseException) and error.full_key:
        return f"{error.full_key}: {str(error).splitlines()[0]}"
    return " ".join(line.strip() for line in str(error).splitlines()[:2])


def _parse(argument: str, parser: OverridesParser) -> Override:
    key, _, value = argument.partition("=")
    try:
        override = parser.parse_override(argument)
    except HydraException as error:
        if not is_override(argument):
            raise InputError(f"{argument!r}: expected key=value or group=choice") from error
        how = f"a list is [a,b], a word with special characters wants quotes, as in \"{key}='{value}'\""
        raise InputError(f"{argument}: cannot be understood; {how}") from error
    if not override.key_or_group:
        raise InputError(f"{argument!r}: expected key=value or group=choice")
    return override


def _check_single(overrides: Iterable[Override]) -> None:
    for override in overrides:
        if override.is_sweep_override():
            key, line = override.key_or_group, override.input_line
            raise InputError(f"{line}: several values want -m; a list is {key}=[a,b], a comma in a word wants quotes")


def _is_group(name: str, places: Sequence[Path]) -> bool:
    return any((place / name).is_dir() for place in places)


def _check_choice(override: Override, places: Sequence[Path]) -> None:
    group = override.key_or_group
    known = choices_of(places).get(group, [])
    for value in _values(override):
        if value not in known:
            raise InputError(f"{group}={value}: expected one of {', '.join(known)}{_meant(value, known)}")


def _elsewhere(key: str, conf: Path) -> str:
    """Which other choices of its group have a key, in words; nothing where none has."""
    group, last = key.partition(".")[0], key.rpartition(".")[2]
    written = re.compile(rf"^\s*{re.escape(last)}\s*:", re.MULTILINE)
    if not any(written.search(file.read_text(encoding="utf-8")) for file in conf.rglob("*.yaml")):
        return ""  # a slip: no need to compose them all
    having = []
    for file in sorted((conf / group).glob("*.yaml")):
        with suppress(HydraException):  # a plugin's, not installed
            other = OmegaConf.select(composed(conf, [f"{group}={file.stem}"]), key.rpartition(".")[0])
            if isinstance(other, DictConfig) and last in list(other) and not last.startswith("_"):
                having.append(f"{group}={file.stem}")
    return f"; {' and '.join(having)} {'has' if len(having) == 1 else 'have'} it" if having else ""


def _check_value(override: Override, cfg: DictConfig, conf: Path) -> None:
    key = override.key_or_group
    if override.type == OverrideType.DEL:
        raise InputError(f"{override.input_line}: a key cannot be taken away; set it to another value")
    *path, last = key.split(".")
    node: Any = cfg
    for depth, name in enumerate(path):
        node = node.get(name) if isinstance(node, DictConfig) and name in node else None
        if not isinstance(node, DictConfig):
            missing, known = ".".join(path[: depth + 1]), _keys(cfg)
            raise InputError(
                f"{override.input_line}: there is no {missing}{_elsewhere(key, conf) or f'; there are {known}'}"
            )
    if last not in list(node) or last.startswith("_"):  # `last in node` is false for a value that is still missing
        where = ".".join(path) or "the configuration"
        others = _elsewhere(key, conf) if path else ""
        meant = _meant(last, map(str, node)) if not others else ""
        raise InputError(
            f"{override.input_line}: there is no {key}{others}; {where} has {_keys(node) or 'no keys'}{meant}"
        )
    if override.type == OverrideType.ADD:
        raise InputError(f"{override.input_line}: {key} is there already; leave the + away")
    if isinstance(node[last] if not OmegaConf.is_missing(node, last) else None, DictConfig):
        raise InputError(
            f"{override.input_line}: expected one of its keys, as in {key}.{_keys(node[last]).split(',')[0]}=…"
        )
    missing = OmegaConf.is_missing(node, last)
    default = None if missing or OmegaConf.is_interpolation(node, last) else node[last]
    values = list(_values(override))
    if isinstance(default, ListConfig) and len(values) > 1 and not any(isinstance(value, list) for value in values):
        raise InputError(f"{override.input_line}: expected {_kind(default)}, as in {key}={_shown(values)}")
    for value in values:
        if default is None:
            if isinstance(value, dict) or (missing and value in (None, "")):
                raise InputError(f"{key}={_shown(value)}: expected a value")
        elif not (_fits(value, default) or (value is None and _takes_none(node, last))):
            typed = f"{key}={_shown(value)}"
            raise InputError(f"{typed}: expected {_kind(default)}, as in {key}={_example(default, value)}")


def _values(override: Override) -> Iterable[Any]:
    """The value, or those a sweep goes through; none of a sweep without a list, such as an interval."""
    if not override.is_sweep_override():
        return [override.value()]
    sweep = override.value()
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
        return isinstance(value, list) and all(_fits(item, default[0]) for item in value if len(default))
    return not isinstance(value, list | dict)


def _takes_none(node: DictConfig, name: str) -> bool:
    """Whether null stands for something: the function that the node is for says so in its signature."""
    if "_target_" not in node:
        return False
    argument = inspect.signature(get_object(node["_target_"])).parameters.get(name)
    return argument is not None and type(None) in get_args(argument.annotation)


def _kind(default: Any) -> str:
    if isinstance(default, ListConfig):
        return f"a list of {_kind(default[0]).split()[-1]}s" if len(default) else "a list"
    return {bool: "true or false", int: "a whole number", float: "a number"}.get(type(default), "a word")


def _example(default: Any, value: Any) -> str:
    """A value that would do: the default, or of an empty list what was typed as one."""
    if isinstance(default, ListConfig) and not len(default):
        return f"[{_shown(value)}]"
    return _shown(default)


def _shown(value: Any) -> str:
    """A value as one types it."""
    if isinstance(value, list | ListConfig):
        return f"[{','.join(map(_shown, value))}]"
    if isinstance(value, dict):
        return f"{{{','.join(f'{key}:{_shown(item)}' for key, item in value.items())}}}"
    return "null" if value is None else str(value).lower() if isinstance(value, bool) else str(value)


def _meant(typed: object, known: Iterable[str]) -> str:
    """Which of the known words is the nearest to the one typed; nothing where none is near."""
    near = difflib.get_close_matches(str(typed), list(known), n=1)
    return f"; did you mean {near[0]}?" if near else ""


def _keys(node: DictConfig) -> str:
    return ", ".join(str(key) for key in node if key not in ("_target_", "_partial_", "hydra"))
