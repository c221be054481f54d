"""Whose folder it is: a run, or a sweep, writes only where no other one that is still alive does.

A claim is a lock on a file in the folder; the system gives it back when the process ends, however it ends. Folders
that are named after the time are made anew, so that two runs of one second have two. Used by `app.py`.
"""

from itertools import count
from pathlib import Path

from filelock import FileLock, Timeout

from lssd_learn.errors import InputError

CLAIM = ".claim"

_held: dict[Path, FileLock] = {}  # by this process, until its end


def claim(folder: Path, key: str) -> None:
    """Take a folder for this process, made if need be.

    Args:
        folder: what was left there by runs that have ended does not matter.
        key: of the configuration, for the message.

    Raises:
        InputError: another process, still alive, has it.
    """
    folder = folder.absolute()
    if folder in _held:
        return
    folder.mkdir(parents=True, exist_ok=True)
    lock = FileLock(folder / CLAIM)
    try:
        lock.acquire(timeout=0)
    except Timeout:
        raise InputError(
            f"{key}={folder}: another run is at work in this folder; wait until it ends, or name another folder"
        ) from None
    _held[folder] = lock


def claim_new(folder: Path, key: str) -> Path:
    """Make a folder that was not there and take it: this one, or with _2, _3, … behind its name."""
    for number in count(1):
        place = folder if number == 1 else folder.with_name(f"{folder.name}_{number}")
        try:
            place.mkdir(parents=True)
            claim(place, key)
        except (FileExistsError, InputError):  # of two that see that it is not there, one makes it
            continue
        return place
    raise AssertionError
