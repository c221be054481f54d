"""A content-addressed store of arrays: what one run computed, the next one reads.

An entry is a folder `<root>/<stage>/<key>/` with one `.npy` file an array and a `manifest.json`. The key is a
fingerprint of everything that changes the result, so an entry is never out of date and a cache never changes a result.
Entries are written beside their place, synced and renamed: a killed run leaves nothing half-made. Every file carries a
checksum; a damaged entry is noticed when it is opened, said in the log and made again.
"""

import hashlib
import json
import logging
import os
import shutil
import zlib
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from filelock import FileLock
from platformdirs import user_cache_path

from lssd_learn.errors import InputError, reading

log = logging.getLogger(__name__)

Arrays = Mapping[str, np.ndarray]

MANIFEST = "manifest.json"
MAPPED = 1 << 20  # bytes from which a file is memory-mapped: to read a smaller one takes less time than to map it


def fingerprint(*parts) -> str:
    """A 32-digit hexadecimal hash of `parts`: strings, numbers, None, and lists or dicts of them; order matters."""
    text = json.dumps(parts, sort_keys=True, separators=(",", ":"), allow_nan=False)
    return hashlib.blake2b(text.encode(), digest_size=16).hexdigest()


def default_root() -> Path:
    """data/cache of the checkout that this package lies in; of an installed package the user's cache folder."""
    above = Path(__file__).parents[1]
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
        self._verified: set[Path] = set()
        self._told_of: set[Path] = set()  # entries found damaged

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
        """The folder of an entry, made or not."""
        return self.root / stage / key

    def get(self, stage: str, key: str, make: Callable[[], Arrays]) -> dict[str, np.ndarray]:
        """The arrays of an entry, memory-mapped; `make` computes them where there is no sound entry.

        Of several processes that want the same entry one computes it, the others wait and read.

        Raises:
            InputError: the cache folder cannot be written.
        """
        found = self.load(stage, key)
        if found is not None:
            return found
        folder = self.root / stage
        with self._told(stage):
            folder.mkdir(parents=True, exist_ok=True)
            lock = FileLock(folder / f".{key}.lock").acquire()
        with lock:
            found = self.load(stage, key)
            if found is None:
                arrays = make()  # its errors are its own
                with self._told(stage):
                    self._write(stage, key, arrays)
                found = self.load(stage, key)
        if found is None:
            raise InputError(f"cache {self.root}: {stage}/{key} was written and cannot be read again")
        return found

    def load(self, stage: str, key: str) -> dict[str, np.ndarray] | None:
        """The arrays of an entry, read-only, large ones memory-mapped; None where it is missing or damaged."""
        folder = self.path(stage, key)
        with reading(f"cache {self.root}"):
            if not folder.is_dir():
                return None
        try:
            manifest = json.loads((folder / MANIFEST).read_text())
            if folder not in self._verified:
                _verify(folder, manifest)
                self._verified.add(folder)
            return {name: _open(f"{folder}/{name}.npy") for name in manifest["arrays"]}
        except (OSError, ValueError, KeyError, TypeError) as fault:
            if folder not in self._told_of:
                self._told_of.add(folder)
                log.warning("cache entry %s/%s is damaged (%s) and is made again", stage, key, fault)
            return None

    @contextmanager
    def _told(self, stage: str) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            raise InputError(f"cache {self.root}: cannot write stage {stage!r}: {error.strerror or error}") from error

    def _write(self, stage: str, key: str, arrays: Arrays) -> None:
        place = self.path(stage, key)
        draft = place.with_name(f".{key}.draft")  # one name: to look for others would be to list the whole stage
        if draft.exists():  # left by a killed run; nobody else writes, for we hold the lock
            shutil.rmtree(draft)
        draft.mkdir(parents=True)
        try:
            manifest = {"arrays": {}}
            for name, array in arrays.items():
                file = draft / f"{name}.npy"
                with file.open("wb") as stream:
                    np.save(stream, np.asarray(array, order="C"), allow_pickle=False)
                    stream.flush()
                    os.fsync(stream.fileno())
                manifest["arrays"][name] = {"bytes": file.stat().st_size, "crc32": _crc32(file)}
            with (draft / MANIFEST).open("w") as stream:
                json.dump(manifest, stream, indent=1)
                stream.flush()
                os.fsync(stream.fileno())
            if place.exists():  # damaged, or it would have been loaded
                shutil.rmtree(place)
            draft.rename(place)
            self._told_of.discard(place)
            _sync(place.parent)
        finally:
            if draft.exists():
                shutil.rmtree(draft)


def _open(path: str) -> np.ndarray:
    if os.path.getsize(path) >= MAPPED:
        return np.load(path, mmap_mode="r")
    array = np.load(path)
    array.setflags(write=False)
    return array


def _sync(folder: Path) -> None:
    """Make a rename in `folder` last through a power cut."""
    if os.name == "posix":  # elsewhere a folder cannot be opened
        handle = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)


def _verify(folder: Path, manifest: dict) -> None:
    for name, expected in manifest["arrays"].items():
        file = folder / f"{name}.npy"
        if file.stat().st_size != expected["bytes"]:
            raise ValueError(f"{name}.npy has {file.stat().st_size} bytes instead of {expected['bytes']}")
        if _crc32(file) != expected["crc32"]:
            raise ValueError(f"{name}.npy has a wrong checksum")


def _crc32(file: Path) -> int:
    value = 0
    with file.open("rb") as stream:
        while block := stream.read(1 << 22):
            value = zlib.crc32(block, value)
    return value


# Where library functions keep what they compute unless told otherwise.
DEFAULT = Cache()
