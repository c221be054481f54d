"""What somebody else's package adds: collections, maps, topologies, differences, nets and tasks, with their yamls.

A package says so by an entry point, `[project.entry-points."lssd_learn.plugins"] theirs = "theirs"`. Importing the
module it names registers differences; a folder `conf` beside that module, with groups as in ours, joins the search path
of the configuration. A checkpoint names classes, and a file shall not name code to run: only those of our rooms, of
such packages and of packages that the configuration in use names are looked up.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path

from lssd_learn.errors import InputError

GROUP = "lssd_learn.plugins"

_named: set[str] = set()  # packages of the configurations in use


@dataclass(frozen=True)
class Plugin:
    """A package that adds to this one.

    Attributes:
        name: of the entry point.
        package: that the module is in.
        conf: its folder of yamls, None without one.
        distribution: what was installed, and
        version: of it.
    """

    name: str
    package: str
    conf: Path | None
    distribution: str
    version: str


@cache
def plugins() -> Sequence[Plugin]:
    """Those that are installed, in the order of their names; each is imported once.

    Raises:
        InputError: one that cannot be imported.
    """
    return [_load(point) for point in sorted(entry_points(group=GROUP), key=lambda point: point.name)]


def _load(point: EntryPoint) -> Plugin:
    try:
        module = import_module(point.module)
    except Exception as error:  # theirs, and of any kind
        reason = f"{type(error).__name__}: {error}"
        raise InputError(f"plug-in {point.name}: {point.module} cannot be imported: {reason}") from error
    # A module that is in no package lies among those of other people, and so would its folder.
    conf = Path(module.__file__).parent / "conf" if module.__package__ and module.__file__ else None
    told = point.dist.name if point.dist else "", point.dist.version if point.dist else ""
    return Plugin(point.name, _top(point.module), conf if conf is not None and conf.is_dir() else None, *told)


def trust(node: object) -> None:
    """Let checkpoints name classes of the packages that a configuration has a `_target_` in.

    Args:
        node: plain nested dicts and lists.
    """
    if isinstance(node, dict):
        if isinstance(target := node.get("_target_"), str):
            _named.add(_top(target))
        for value in node.values():
            trust(value)
    elif isinstance(node, list):
        for value in node:
            trust(value)


def find_class(path: str, kind: type, what: str) -> type:
    """The class that a file names by its full path.

    Args:
        path: package.module.Class.
        kind: what it has to be.
        what: the file and what it wants it for, for messages.

    Raises:
        InputError: of a package that is neither a plug-in nor named by the configuration in use; no such class.
    """
    ours, package = _top(__name__), _top(path)
    if package not in {ours, *_named, *(plugin.package for plugin in plugins())}:
        raise InputError(
            f"{what} {path}, but {package} is no plug-in of {ours}, and a file shall not name code to run: "
            "name it in the configuration, or install it with its entry point"
        )
    *modules, last = path.split(".")
    try:
        found = getattr(import_module(".".join(modules)), last)
    except (ImportError, AttributeError, ValueError) as error:
        raise InputError(f"{what} {path}, which is not there: {error}") from error
    # What a module has imported from elsewhere is no part of its package.
    if not (isinstance(found, type) and issubclass(found, kind) and _top(found.__module__) == package):
        raise InputError(f"{what} {path}: expected a class of {package} that is a {kind.__name__}")
    return found


def _top(path: str) -> str:
    return path.partition(".")[0]
