"""What a yaml of the configuration says about itself: its first comment, and each key with its value and comment.

Read as text: `--help` answers without what a run imports. A comment above a group of keys belongs to the next one.
"""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import yaml

from lssd_learn.errors import InputError

PACKAGE = "@package"
EXAMPLE = "Example: "
KEY = re.compile(r"^( *)([\w/@.]+):(?:\s+(.*))?$")


@dataclass(frozen=True)
class Key:
    """A key of a yaml.

    Attributes:
        name: with those it lies in, by dots.
        value: as it is written there.
        meaning: its comment.
    """

    name: str
    value: str
    meaning: str


@dataclass(frozen=True)
class Told:
    """What a yaml says.

    Attributes:
        what: what it is, in a sentence or two.
        examples: command lines.
        package: where its keys lie, as `@package` says; None for its own group.
        target: the function or class it names, None without one.
        chosen: choices of other groups that come with it, as group=choice.
        keys: its own and those it takes over from others of its group.
    """

    what: str
    examples: Sequence[str]
    package: str | None
    target: str | None
    chosen: Sequence[str]
    keys: Sequence[Key]


def conf() -> Path:
    """The folder of the configuration: inside the installed package, or beside it in a checkout."""
    package = Path(__file__).parents[1]
    return package / "conf" if (package / "conf").is_dir() else package.parent / "conf"


def groups(folders: Sequence[Path]) -> dict[str, list[str]]:
    """The groups of some folders of yamls, each with its choices; those of Hydra itself are left out."""
    found: dict[str, set[str]] = {}
    for folder in folders:
        for file in folder.glob("*/*.yaml"):
            found.setdefault(file.parent.name, set()).add(file.stem)
    return {name: sorted(found[name]) for name in sorted(found) if name != "hydra"}


def told(folders: Sequence[Path], group: str, choice: str) -> Told:
    """What a yaml says; of two of one name that of the first folder counts.

    Raises:
        InputError: there is none, or it is no yaml.
    """
    file = next((path for folder in folders if (path := folder / group / f"{choice}.yaml").is_file()), None)
    if file is None:
        raise InputError(f"{group}={choice}: expected one of {', '.join(groups(folders).get(group, ()))}")
    text = file.read_text(encoding="utf-8")
    try:
        content = yaml.safe_load(text) or {}
    except yaml.YAMLError as error:
        raise InputError(f"{file}: {' '.join(str(error).split())}") from error
    first = list(_head(text))
    packages = [line.removeprefix(PACKAGE).strip() for line in first if line.startswith(PACKAGE)]
    chosen, keys, target = [], {}, None
    for entry in content.get("defaults", ()):
        if isinstance(entry, dict):
            ((name, other),) = entry.items()
            chosen.append(f"{name.removeprefix('override').strip().lstrip('/').partition('@')[0]}={other}")
        elif entry != "_self_":
            other, at, place = str(entry).partition("@")
            base = told(folders, group, other)
            target = base.target if not at else target
            keys |= {key.name: key for key in _placed(base.keys, place)}
    for key in _keys(text):
        meaning = key.meaning or (keys[key.name].meaning if key.name in keys else "")
        keys[key.name] = replace(key, meaning=meaning)
    return Told(
        what=" ".join(line for line in first if not line.startswith((PACKAGE, EXAMPLE))),
        examples=[line.removeprefix(EXAMPLE) for line in first if line.startswith(EXAMPLE)],
        package=packages[0] if packages else None,
        target=content.get("_target_", target),
        chosen=chosen,
        keys=list(keys.values()),
    )


def _placed(keys: Sequence[Key], place: str) -> Sequence[Key]:
    return [replace(key, name=f"{place}.{key.name}") for key in keys] if place else keys


def _head(text: str) -> Iterator[str]:
    """The comment that a text begins with, line by line."""
    for line in text.splitlines():
        if not line.startswith("#"):
            return
        yield line.lstrip("# ")


def _keys(text: str) -> Iterator[Key]:
    """Every key that has a value of its own; what only holds others counts if it is explained."""
    lines = [line for line in text.splitlines()[len(list(_head(text))) :] if line.strip()]
    path: list[str] = []
    above: list[str] = []
    for i, line in enumerate(lines):
        if line.lstrip().startswith("#"):
            above.append(line.strip("# "))
            continue
        if (match := KEY.match(line)) is None:
            continue  # an entry of a list
        indent, name, rest = match.groups()
        path = [*path[: len(indent) // 2], name]
        value, _, comment = (rest or "").partition("#") if not (rest or "").startswith("#") else ("", "", rest[1:])
        following = lines[i + 1] if i + 1 < len(lines) else ""
        holds = not value.strip() and len(following) - len(following.lstrip()) > len(indent)
        if path[0] not in ("_target_", "_partial_", "defaults") and not (holds and not comment):
            yield Key(".".join(path), value.strip(), " ".join([*above, comment.strip()]).strip())
        above = []
