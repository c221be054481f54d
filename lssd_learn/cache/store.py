"""A content-addressed store of arrays: what one run computed, the next one reads.

An entry is a file `<root>/<stage>/<xx>/<key>.arrays`, xx the first two letters of the key, so that no folder holds more
than a few hundred of 100,000 entries; `packed.py` says what is in it. The key is a fingerprint of everything that
changes the result, so an entry is never out of date and a cache never changes a result. Entries are written beside
their place and renamed: a killed run leaves nothing half-made. Nothing is synced to the disk, which would take longer
than most of what is computed: after a power cut the last entries may be empty or cut off. All carry checksums; a
damaged entry is noticed when it is opened, said in the log and made again.
"""

import hashlib
import json
import logging
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import numpy as np
from filelock import FileLock
from platformdirs import user_cache_path

from lssd_learn.cache.packed import Arrays, read, read_folder, write
from lssd_learn.errors import InputError

log = logging.getLogger(__name__)


def fingerprint(*parts) -> str:
    """A 32-digit hexadecimal hash of `parts`: strings, numbers, None, and lists or dicts of them; order matters."""
    text = json.dumps(parts, sort_keys=True, separators=(",", ":"), allow_nan=False)
    return hashlib.blake2b(text.encode(), digest_size=16).hexdigest()


def default_root() -> Path:
    """data/cache of the checkout that this package lies in; of an installed package the user's cache folder."""
    above = Path(__file__).parents[2]
    return above / "data" / "cache" if (above / "train.py").is_file() else user_cache_path("lssd_learn", False)


class Cache:
    """The store below one folder. `$LSSD_CACHE`, where set, takes the place of `root`.

    Args:
        root: the folder, made when the first entry is written; None is `default_root`.

    Examples:
        >>> import tempfile
        >>> import numpy as np
        >>> import lssd_learn as lssd
        >>> cache = lssd.Cache(tempfile.mkdtemp())
    """

    def __init__(self, root: str | Path | None = None):
        self._root = default_root() if root is None else Path(root)
        self._verified: set[str] = set()
        self._told_of: set[str] = set()  # entries found damaged

    def __getstate__(self):
        # A worker process verifies for itself.
        return {**vars(self), "_verified": set()}

    def __repr__(self) -> str:
        return f"Cache({str(self.root)!r})"

    @property
    def root(self) -> Path:
        """The folder, where it is now: the environment and the working directory may change while a program runs."""
        return Path(os.environ.get("LSSD_CACHE") or self._root).expanduser().absolute()

    def path(self, stage: str, key: str) -> Path:
        """The file of an entry, made or not."""
        return self.root / stage / key[:2] / f"{key}.arrays"

    def get(self, stage: str, key: str, make: Callable[[], Arrays]) -> dict[str, np.ndarray]:
        """The arrays of an entry, memory-mapped; `make` computes them where there is no sound entry.

        Of several processes that want the same entry one computes it, the others wait and read.

        Raises:
            InputError: the cache folder cannot be written.
        """
        found = self.load(stage, key)
        if found is not None:
            return found
        place = self.path(stage, key)
        lock = FileLock(place.with_name(f".{key}.lock"))
        with self._told(stage):
            place.parent.mkdir(parents=True, exist_ok=True)
            lock.acquire()
        with lock:
            found = self.load(stage, key)
            if found is None:
                arrays = make()  # its errors are its own
                with self._told(stage):
                    self._write(place, arrays)
                found = self.load(stage, key)
            with suppress(OSError):  # whoever waits for it finds the entry; Windows removes no file that is open
                os.unlink(lock.lock_file)
        if found is None:
            raise InputError(f"cache {self.root}: {stage}/{key} was written and cannot be read again")
        return found

    def load(self, stage: str, key: str) -> dict[str, np.ndarray] | None:
        """The arrays of an entry, read-only, large ones memory-mapped; None where it is missing or damaged."""
        root = os.fspath(self.root)
        place, before = f"{root}/{stage}/{key[:2]}/{key}.arrays", f"{root}/{stage}/{key}"
        for path, open_ in ((place, read), (before, read_folder)):
            try:
                arrays = open_(path, path not in self._verified)
                self._verified.add(path)
                return arrays
            except (FileNotFoundError, NotADirectoryError):
                if open_ is read or not os.path.exists(f"{path}/manifest.json"):
                    continue
                fault = "a file is missing"
            except PermissionError as error:
                raise InputError(f"cache {root}: cannot be read: {error.strerror}") from error
            except (OSError, ValueError, KeyError, TypeError) as error:
                fault = error
            if path not in self._told_of:
                self._told_of.add(path)
                log.warning("cache entry %s/%s is damaged (%s) and is made again", stage, key, fault)
            return None
        return None

    @contextmanager
    def _told(self, stage: str) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            raise InputError(f"cache {self.root}: cannot write stage {stage!r}: {error.strerror or error}") from error

    def _write(self, place: Path, arrays: Arrays) -> None:
        # One name: to look for others would be to list a folder. One left by a killed run is written over; nobody else
        # writes, for we hold the lock.
        draft = place.with_suffix(".draft")
        try:
            with draft.open("wb") as stream:
                write(stream, arrays)
            os.replace(draft, place)
            self._told_of.discard(os.fspath(place))
            self._verified.discard(os.fspath(place))
        finally:
            draft.unlink(missing_ok=True)


# Where library functions keep what they compute unless told otherwise.
DEFAULT = Cache()
