"""Guards the folder in which anny keeps its built models, so that no run ever reads a half-written one.

anny writes each file of hundreds of megabytes in place: a kill in mid-write leaves a truncated file that every later
run would trip over. `model.py` therefore loads its model inside `guarded(folder)`: one process at a time, broken
files removed first, new ones built in a staging folder and renamed into place whole.
"""

import json
import logging
import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from filelock import FileLock, Timeout

from lssd_learn.errors import InputError

log = logging.getLogger(__name__)

STAGING = ".staging-"


@contextmanager
def guarded(folder: Path) -> Iterator[Path]:
    """Yield a staging folder that shows what is intact in `folder`; what is new in it is moved to `folder` at the end.

    Cheap when nothing is added: files are linked, not copied, and only their headers are read. Nothing is moved if the
    body of the with statement raises.

    Raises:
        InputError: `folder` cannot be written.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        lock = _lock(folder)
    except OSError as error:
        raise InputError(
            f"{folder}: the body model is kept here and it cannot be written ({error.strerror}); "
            "set ANNY_CACHE_DIR to a folder that can"
        ) from error
    try:
        # Whoever holds the lock is alone: a staging folder that is already there was left by a killed run.
        for stale in folder.glob(f"{STAGING}*"):
            shutil.rmtree(stale, ignore_errors=True)
        staging = Path(tempfile.mkdtemp(prefix=STAGING, dir=folder))
        try:
            _link_intact(folder, staging)
            yield staging
            _move_new(staging, folder)
        finally:
            shutil.rmtree(staging, ignore_errors=True)
    finally:
        lock.release()


def is_intact(path: Path) -> bool:
    """Whether a safetensors file is as long as its own header says: 8 bytes, the header, the tensors."""
    try:
        size = path.stat().st_size
        with path.open("rb") as file:
            length = int.from_bytes(file.read(8), "little")
            if not 0 < length <= size - 8:
                return False
            header = json.loads(file.read(length))
        ends = [entry["data_offsets"][1] for name, entry in header.items() if name != "__metadata__"]
        return size == 8 + length + max(ends, default=0)
    except (ValueError, LookupError, TypeError, AttributeError):
        return False


def _lock(folder: Path) -> FileLock:
    lock = FileLock(folder / ".lock")
    try:
        lock.acquire(timeout=5)
    except Timeout:
        log.info("waiting for another process that builds the body model")
        lock.acquire()
    return lock


def _link_intact(folder: Path, staging: Path) -> None:
    for path in sorted(folder.glob("v*/*.safetensors")):
        if not is_intact(path):
            log.warning("%s is damaged, probably by a killed run: removed, it will be built again", path)
            path.unlink()
            continue
        link = staging / path.relative_to(folder)
        link.parent.mkdir(exist_ok=True)
        try:
            os.link(path, link)
        except OSError:  # a file system without hard links
            shutil.copy2(path, link)


def _move_new(staging: Path, folder: Path) -> None:
    for path in sorted(staging.glob("v*/*.safetensors")):
        target = folder / path.relative_to(staging)
        if not target.exists():
            target.parent.mkdir(exist_ok=True)
            os.replace(path, target)
