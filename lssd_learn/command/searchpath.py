"""Where the configuration is looked for: our folder, those of plug-ins, and those that the command line names.

Used by `app.py`, which runs, and by `overrides.py`, which checks what is typed.
"""

from collections.abc import Sequence
from importlib.resources import files
from pathlib import Path

from hydra.core.config_search_path import ConfigSearchPath
from hydra.core.override_parser.overrides_parser import OverridesParser
from hydra.core.plugins import Plugins
from hydra.errors import HydraException
from hydra.plugins.search_path_plugin import SearchPathPlugin

from lssd_learn.errors import InputError
from lssd_learn.plugins import plugins

FOLDER = ("--config-dir", "-cd")
KEY = "hydra.searchpath"


class PluginFolders(SearchPathPlugin):
    """Adds the folders of plug-ins, behind ours: a yaml of ours is not replaced by one of the same name."""

    def manipulate_search_path(self, search_path: ConfigSearchPath) -> None:
        for plugin in plugins():
            if plugin.conf is not None:
                search_path.append(f"lssd_learn.plugins:{plugin.name}", f"file://{plugin.conf}")


def join() -> None:
    """Make Hydra look into the folders of plug-ins."""
    if PluginFolders not in Plugins.instance().discover(SearchPathPlugin):
        Plugins.instance().register(PluginFolders)


def named(arguments: Sequence[str]) -> list[str]:
    """What the command line adds to the search path: folders, `file://…` and `pkg://…`."""
    found, parser = [], OverridesParser.create()
    for i, argument in enumerate(arguments):
        option, equals, value = argument.partition("=")
        if option in FOLDER:
            found += [str(Path(place).absolute()) for place in ([value] if equals else arguments[i + 1 : i + 2])]
        elif option.lstrip("+") == KEY:
            try:
                given = parser.parse_override(argument).value()
            except HydraException:
                continue  # refused with all that cannot be understood
            found += map(str, given) if isinstance(given, list) else []
    return found


def folders(conf: Path, arguments: Sequence[str]) -> list[Path]:
    """The folders that yamls come from; of two of one name that of the first folder counts.

    Raises:
        InputError: the command line names one that is not there.
    """
    return [conf, *(plugin.conf for plugin in plugins() if plugin.conf is not None), *map(_folder, named(arguments))]


def override(places: Sequence[str]) -> list[str]:
    """What makes `compose` look there too, as an override; none of none."""
    quoted = ("'" + place.replace("\\", "\\\\").replace("'", "\\'") + "'" for place in places)
    return [f"{KEY}=[{','.join(quoted)}]"] if places else []


def _folder(place: str) -> Path:
    scheme, there, rest = place.partition("://")
    try:
        folder = Path(str(files(rest.replace("/", ".")))) if scheme == "pkg" else Path(rest if there else place)
    except ModuleNotFoundError as error:
        raise InputError(f"{place}: expected a folder of the configuration: {error}") from error
    if not folder.is_dir():
        raise InputError(f"{place}: expected a folder of the configuration, and there is none")
    return folder
