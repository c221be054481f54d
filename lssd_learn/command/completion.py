"""Shell completion, `lssd -sc install=bash`: Hydra's own, without what a run imports, which takes seconds a key."""

import hydra

from lssd_learn.command.searchpath import join
from lssd_learn.command.yamls import conf


def complete() -> None:
    """Answer a command line that asks for completion: Hydra prints the choices, or what installs it in a shell."""
    join()
    hydra.main(version_base="1.3", config_path=str(conf()), config_name="config")(lambda _: None)()
