"""The one error for what comes from outside: command line, files, cache, checkpoints; and the checks all rooms use."""

import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from numbers import Integral, Real
from typing import cast

MOST_SEED = 2**63 - 1  # that torch takes


class InputError(ValueError):
    """Bad input, told in one line: the file or argument, what was expected, what came.

    Raised where something enters the program, never inside it. The command line prints the message without a
    traceback and ends with exit status 1.

    Examples:
        >>> import lssd_learn as lssd
        >>> lssd.load("nowhere.ply")
        Traceback (most recent call last):
            ...
        lssd_learn.errors.InputError: nowhere.ply: ...
    """


def check_whole(name: str, value, least: int, most: int | None = None) -> None:
    """Refuse anything but a whole number from `least` to `most`.

    Raises:
        InputError: names the argument, what was expected and what came.
    """
    most_or_any = math.inf if most is None else most
    # True and False are whole numbers to Python, and never meant as such.
    if isinstance(value, bool) or not isinstance(value, Integral) or not least <= int(value) <= most_or_any:
        bounds = f"{least:,} or more" if most is None else f"{least:,} to {most:,}"
        raise InputError(f"{name}={value}: expected a whole number, {bounds}")


def check_positive(name: str, value) -> None:
    """Refuse anything but a finite number above 0.

    Raises:
        InputError: names the argument, what was expected and what came.
    """
    if isinstance(value, bool) or not isinstance(value, Real) or not 0 < cast(float, value) < math.inf:
        raise InputError(f"{name}={value}: expected a number above 0")


def some_of(names: Sequence[str], most: int = 5) -> str:
    """The first of many names for a message: "a, b and 12 more"."""
    more = f" and {len(names) - most:,} more" if len(names) > most else ""
    return ", ".join(names[:most]) + more


@contextmanager
def reading(path) -> Iterator[None]:
    """Tell of a file or folder that the system does not let us read.

    Raises:
        InputError: names the path and the system's reason.
    """
    try:
        yield
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror or error}") from error
