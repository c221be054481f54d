"""`--help`: what tasks there are; with `task=compare` and other choices beside it, what their keys mean.

Everything told stands in the yamls, and nothing is imported that a run needs: the answer comes at once.
"""

import shutil
import textwrap
from collections.abc import Iterator, Sequence
from pathlib import Path

from lssd_learn.command.yamls import Told, conf, groups, told
from lssd_learn.errors import InputError
from lssd_learn.plugins import plugins

OF_OPTIONS = "--hydra-help"
ASKED = ("--help", "-h", OF_OPTIONS)
WIDTH = 100  # at most, however wide the terminal is
ROOMS = {"tasks": "On shapes", "measures": "Against a known truth, and for speed", "studies": "The paper's studies"}

HEAD = "Latent space shape differences: from a collection of shapes to small matrices, and what is learnt from them."
USAGE = """\
lssd                          the main job: bodies, clique, CNN
lssd net=mlp latent.keep=30   other choices, other values
lssd -m seed=0,1 net=cnn,mlp  a sweep: every combination
lssd measure scan.ply         body measures of scans; lssd measure --help
lssd task=compare --help      what its keys mean; so does any other choice
lssd collection --help        what choices a group has
lssd --hydra-help             options
lssd --version\
"""
OPTIONS = """\
Options, read by Hydra (https://hydra.cc); all else on the line is key=value.

  -m, --multirun          every combination of the values with commas between
                          them, a run each; then a summary
  -c, --cfg job           the configuration, and nothing is run; hydra, all
  -p, --package latent    of --cfg: this part of it
  --resolve               of --cfg: with what ${...} stands for
  -i, --info defaults     where the configuration comes from; searchpath,
                          plugins, config, defaults-tree
  -cd, --config-dir=DIR   a folder of yamls of your own, in groups
  -sc install=bash        prints what completes in a shell, zsh and fish too:
                          eval "$(lssd -sc install=bash)"; uninstall=bash
  -h, --help, --version

Keys of its own: hydra.run.dir=DIR, hydra.sweep.dir=DIR; all: --cfg hydra.\
"""


def tell(arguments: Sequence[str]) -> str:
    """The answer to a command line that asks for help.

    Args:
        arguments: the command line; group=choice and the names of groups in it are explained, or its options.

    Raises:
        InputError: no such group or choice.
    """
    if OF_OPTIONS in arguments:
        return OPTIONS
    folders = [conf(), *(plugin.conf for plugin in plugins() if plugin.conf is not None), *_named(arguments)]
    there = groups(folders)
    asked = [part for part in arguments if part.partition("=")[0] in there]
    if unknown := [part for part in arguments if not part.startswith("-") and "=" not in part and part not in there]:
        raise InputError(f"{unknown[0]}: expected group=choice or one of the groups {', '.join(there)}")
    parts = [
        _one(told(folders, group, choice), group, choice) if equals else _all(folders, group, there[group])
        for group, equals, choice in (part.partition("=") for part in asked)
    ]
    return "\n\n".join(parts) if parts else _overview(folders, there)


def _named(arguments: Sequence[str]) -> list[Path]:
    """The folders of yamls that the command line names."""
    if not any(part.startswith(("--config-dir", "-cd", "hydra.searchpath")) for part in arguments):
        return []
    from lssd_learn.command.searchpath import folders  # takes its time

    return list(folders(conf(), arguments))


def _overview(folders: Sequence[Path], there: dict[str, list[str]]) -> str:
    tasks = {choice: told(folders, "task", choice) for choice in there["task"]}
    rooms = {name: ((one.target or "") + "..").split(".")[:2] for name, one in tasks.items()}
    lines = [*textwrap.wrap(HEAD, _width()), "", "python train.py, in a checkout, is the same as lssd.", ""]
    for room, title in ROOMS.items():
        mine = [name for name in tasks if rooms[name] == ["lssd_learn", room]]
        lines += [f"{title}, as task=…", *_table([(name, _first(tasks[name].what)) for name in mine]), ""]
    if others := [name for name in tasks if rooms[name][0] != "lssd_learn"]:
        lines += ["Of plug-ins, as task=…", *_table([(name, _first(tasks[name].what)) for name in others]), ""]
    rest = [(name, ", ".join(choices)) for name, choices in there.items() if name != "task"]
    return "\n".join([*lines, "Other choices, as group=choice", *_table(rest), "", USAGE])


def _all(folders: Sequence[Path], group: str, choices: Sequence[str]) -> str:
    rows = [(choice, _first(told(folders, group, choice).what)) for choice in choices]
    return "\n".join([f"{group}=…", *_table(rows)])


def _one(one: Told, group: str, choice: str) -> str:
    lines = textwrap.wrap(f"{group}={choice}: {one.what}" if one.what else f"{group}={choice}", _width())
    if one.chosen:
        lines += textwrap.wrap(f"With {', '.join(one.chosen)} where nothing else is said.", _width())
    prefix = "" if one.package == "_global_" else f"{one.package or group}."
    rows = [(f"{prefix}{key.name}={_shown(key.value)}", key.meaning) for key in one.keys]
    lines += ["", *_table(rows, most=38)] if rows else ["", "  no keys of its own"]
    if one.examples:
        lines += ["", "Example" if len(one.examples) == 1 else "Examples", *(f"  {line}" for line in one.examples)]
    return "\n".join(lines)


def _shown(value: str) -> str:
    return "…  (must be given)" if value == "???" else value


def _first(what: str) -> str:
    """The first sentence."""
    return what.partition(". ")[0].rstrip(".")


def _table(rows: Sequence[tuple[str, str]], most: int = 26) -> Iterator[str]:
    """Two columns; a left entry that is too wide has a line of its own."""
    if not rows:
        return
    left = min(max(len(name) for name, _ in rows), most) + 2
    for name, text in rows:
        wrapped = textwrap.wrap(text, max(_width() - left - 2, 30)) or [""]
        if len(name) > left - 2:
            yield f"  {name}"
            name = ""
        yield from (f"  {start:<{left}}{line}".rstrip() for start, line in zip([name, *[""] * 99], wrapped))  # noqa: B905


def _width() -> int:
    return min(shutil.get_terminal_size().columns, WIDTH)
