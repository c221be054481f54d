"""The command line, understood or refused before anything that takes long to import.

Torch and the tasks take seconds, a misspelt key a third of one.
"""

from collections.abc import Sequence

from hydra.errors import HydraException
from omegaconf.errors import OmegaConfBaseException

from lssd_learn.command.overrides import check, explain, is_override
from lssd_learn.command.searchpath import join
from lssd_learn.command.typed import as_typed
from lssd_learn.command.yamls import conf
from lssd_learn.errors import InputError


def understood(given: Sequence[str]) -> list[str]:
    """The arguments as Hydra is to read them.

    Raises:
        InputError: in one line, what is wrong with them.
    """
    try:
        join()
        # Options first: argparse takes no overrides after one that stands between them.
        arguments = as_typed(sorted(given, key=is_override), conf())
        check(arguments, conf())
    except (HydraException, OmegaConfBaseException) as error:
        raise InputError(explain(error)) from error
    return arguments
