"""What a folder has to say of its shapes: each thing once a run, and the warnings again in the next run."""

import logging
from collections.abc import Iterable

log = logging.getLogger("lssd_learn.collections.folder")


class Told:
    """What was said so far, in the order it was said in; `warnings` are those that every run should hear."""

    def __init__(self):
        self._said: dict[str, int] = {}

    @property
    def warnings(self) -> list[str]:
        return [message for message, level in self._said.items() if level >= logging.WARNING]

    @property
    def messages(self) -> list[str]:
        """All of them."""
        return list(self._said)

    def say(self, message: str) -> None:
        """Log what was done, the first time."""
        self._once(message, logging.INFO)

    def warn(self, message: str) -> None:
        """Log what may make a result wrong, the first time."""
        self._once(message, logging.WARNING)

    def remind(self, warnings: Iterable[str]) -> None:
        """Log the warnings of an earlier run that were not said in this one."""
        for message in warnings:
            self.warn(message)

    def _once(self, message: str, level: int) -> None:
        if message not in self._said:
            self._said[message] = level
            log.log(level, "%s", message)
