"""Named arrays in one file: how an entry of the cache lies on disk.

The arrays come one after the other as they lie in memory, each from a multiple of 64 bytes on, so that a part of the
file can be memory-mapped; then an index in JSON, name → dtype, shape, offset, bytes and checksum; then the length and
the checksum of the index, and a mark. Whoever reads begins at the end: a file that was cut off has none.
"""

import json
import os
import struct
import zlib
from collections.abc import Mapping
from pathlib import Path
from typing import BinaryIO

import numpy as np

Arrays = Mapping[str, np.ndarray]

MAPPED = 1 << 20  # bytes from which an array is memory-mapped: to read a smaller one takes less time than to map it
ALIGNED = 64  # bytes
MARK = b"LSSDarr1"
TRAILER = struct.Struct("<II8s")  # length and CRC-32 of the index, the mark
BLOCK = 1 << 22  # bytes of a large file that are read at once


def write(stream: BinaryIO, arrays: Arrays) -> None:
    """Write arrays of numbers, truth values or texts.

    Raises:
        ValueError: an array of objects, or with fields.
    """
    index, place = {}, 0
    for name, given in arrays.items():
        array = np.asarray(given, order="C")
        if array.dtype.hasobject or array.dtype.fields is not None:
            raise ValueError(f"{name}: expected an array of numbers, truth values or texts, got {array.dtype}")
        gap = -place % ALIGNED
        content = array.reshape(-1).view(np.uint8) if array.nbytes else np.empty(0, np.uint8)
        stream.write(bytes(gap))
        stream.write(content.data)
        place += gap
        index[name] = [array.dtype.str, array.shape, place, array.nbytes, zlib.crc32(content.data)]
        place += array.nbytes
    told = json.dumps(index).encode()
    stream.write(told + TRAILER.pack(len(told), zlib.crc32(told), MARK))


def read(path: str | Path, verify: bool = True) -> dict[str, np.ndarray]:
    """What `write` wrote, read-only; large arrays memory-mapped.

    Args:
        path: of the file.
        verify: the checksums of the arrays. The index is always.

    Raises:
        OSError, ValueError: the file is not there, or damaged; says where.
    """
    with open(path, "rb") as stream:
        size = os.fstat(stream.fileno()).st_size
        if size < MAPPED:
            content = stream.read()
            tail = content[-TRAILER.size :]
        else:
            content = None
            stream.seek(-TRAILER.size, os.SEEK_END)
            tail = stream.read()
        if len(tail) < TRAILER.size or tail[-len(MARK) :] != MARK:
            raise ValueError("it is cut off or something else")
        length, checksum, _ = TRAILER.unpack(tail)
        begin = size - TRAILER.size - length
        if content is not None:
            told = content[max(begin, 0) : -TRAILER.size]
        else:
            stream.seek(max(begin, 0))
            told = stream.read(length)
        if zlib.crc32(told) != checksum:
            raise ValueError("its index has a wrong checksum")
        arrays = {}
        for name, (dtype, shape, offset, nbytes, expected) in json.loads(told).items():
            if content is None and nbytes >= MAPPED:
                array = np.memmap(path, dtype, "r", offset, tuple(shape))
                found = _checksum(stream, offset, nbytes) if verify else expected
            else:
                if content is None:
                    stream.seek(offset)
                part = stream.read(nbytes) if content is None else memoryview(content)[offset : offset + nbytes]
                # A copy: whoever keeps one array would keep the whole file.
                array = np.ndarray(tuple(shape), dtype, bytes(0) if not nbytes else part).copy()
                array.setflags(write=False)
                found = zlib.crc32(part) if verify else expected
            if found != expected:
                raise ValueError(f"{name} has a wrong checksum")
            arrays[name] = array
    return arrays


def read_folder(folder: str | Path, verify: bool = True) -> dict[str, np.ndarray]:
    """The arrays of an entry as earlier versions wrote it: a folder of `.npy` files beside a manifest.

    Raises:
        OSError, ValueError, KeyError, TypeError: it is damaged.
    """
    manifest, arrays = json.loads((Path(folder) / "manifest.json").read_text()), {}
    for name, expected in manifest["arrays"].items():
        file = f"{folder}/{name}.npy"
        if verify:
            with open(file, "rb") as stream:
                size = os.fstat(stream.fileno()).st_size
                if size != expected["bytes"] or _checksum(stream, 0, size) != expected["crc32"]:
                    raise ValueError(f"{name}.npy has a wrong checksum")
        arrays[name] = np.load(file, mmap_mode="r" if os.path.getsize(file) >= MAPPED else None)
        arrays[name].setflags(write=False)
    return arrays


def _checksum(stream: BinaryIO, offset: int, nbytes: int) -> int:
    value, left = 0, nbytes
    stream.seek(offset)
    while left and (block := stream.read(min(BLOCK, left))):
        value, left = zlib.crc32(block, value), left - len(block)
    return value if not left else -1
