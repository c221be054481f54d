"""What was typed for a word is that word: Hydra's grammar reads 2024_05_12 as the number 20240512, and 1e3 as 1000.0.

The values of keys that want a word or a path, where they look like numbers, are put in quotes before Hydra sees them.
Used by `app.py`.
"""

import inspect
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any, cast, get_args

from hydra.core.override_parser.overrides_parser import OverridesParser
from hydra.errors import HydraException
from hydra.utils import get_object
from omegaconf import DictConfig, ListConfig, OmegaConf

from lssd_learn.command.composed import composed
from lssd_learn.command.searchpath import named, override

PATHS = ("ckpt_path", "hydra.run.dir", "hydra.sweep.dir", "hydra.sweep.subdir")
WORDS = ("data.held_out", "parallel.address")  # without a default that would say so
FORMULAS = (
    "task.formula",
    "task.nuisance",
    "task.without",
)  # brackets and commas are their own


def as_typed(arguments: Sequence[str], conf: Path) -> list[str]:
    """The arguments, with quotes around what looks like a number and is a word, and around formulas.

    Args:
        arguments: of the command line; those that are no overrides, or wrong ones, are left as they are.
        conf: the folder of the configuration.
    """
    arguments = [_formula(argument) for argument in arguments]
    if not any(re.search(r"[=,\[]\s*[\d+-.infa]", argument) for argument in arguments):
        return list(arguments)
    parser = OverridesParser.create()
    groups = [a for a in arguments if "=" in a and (conf / a.partition("=")[0]).is_dir() and "," not in a]
    try:
        cfg = composed(conf, [*groups, *override(named(arguments))])
    except HydraException:  # a wrong choice, which is told of elsewhere
        return list(arguments)
    return [_quoted(a, parser, cfg) for a in arguments]


def _quoted(argument: str, parser: OverridesParser, cfg: DictConfig) -> str:
    key, sign, text = argument.partition("=")
    if not sign or argument.startswith("-") or not _wants_words(key.lstrip("+"), cfg):
        return argument
    listed = text.startswith("[") and text.endswith("]")
    inner = text[1:-1] if listed else text
    if re.search(r"[\[\](){}'\"\\$]", inner):  # quotes, sweeps and nested values stand for themselves
        return argument
    words = [f"'{word.strip()}'" if _is_number(word.strip(), parser) else word for word in inner.split(",")]
    joined = ",".join(words)
    return f"{key}=[{joined}]" if listed else f"{key}={joined}"


def _formula(argument: str) -> str:
    """A formula in quotes, if it is one and has none yet."""
    key, sign, text = argument.partition("=")
    text = text.strip()
    if not sign or key not in FORMULAS or text[:1] in ("'", '"', "$") or text in ("", "null"):
        return argument
    escaped = text.replace("'", "\\'")
    return f"{key}='{escaped}'"


def _is_number(word: str, parser: OverridesParser) -> bool:
    """Whether Hydra takes a word for a number or a truth value."""
    try:
        value = parser.parse_override(f"key={word}").value()
    except HydraException:
        return False
    return isinstance(value, bool | int | float)


def _wants_words(key: str, cfg: DictConfig) -> bool:
    if key in PATHS + WORDS:
        return True
    node, _, last = key.rpartition(".")
    parent: Any = OmegaConf.select(cfg, node) if node else cfg
    if not isinstance(parent, DictConfig) or last not in list(parent):
        return False
    default = (
        None
        if OmegaConf.is_missing(parent, last)
        else cast(dict[str, Any], OmegaConf.to_container(parent, resolve=False))[last]
    )
    if default is None or isinstance(default, list) and not default:
        return _annotated(parent, last)
    first = default[0] if isinstance(default, list | ListConfig) else default
    return isinstance(first, str) and not first.startswith("${")


def _annotated(parent: DictConfig, name: str) -> bool:
    """Whether the function that the node is for wants words there, and no numbers."""
    if "_target_" not in parent:
        return False
    parameter = inspect.signature(get_object(parent["_target_"])).parameters.get(name)
    kinds = _kinds(parameter.annotation) if parameter is not None else set()
    return bool(kinds & {str, Path}) and not kinds & {int, float}


def _kinds(annotation: Any) -> set:
    inner = get_args(annotation)
    return set().union(*map(_kinds, inner)) if inner else {annotation}
