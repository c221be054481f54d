"""The arrays in a GLB: buffers, views of them, types, normalised whole numbers, sparse changes. Used by `glb.py`."""

import base64
import binascii

import numpy as np
from jaxtyping import Float, Int

_TYPES = {5120: "i1", 5121: "u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
_WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}


class Accessors:
    """Reads the accessors of a glTF tree.

    Args:
        tree: the JSON.
        numbers: the binary chunk.
    """

    def __init__(self, tree: dict, numbers: bytes):
        self._accessors, self._views = tree.get("accessors", []), tree.get("bufferViews", [])
        self._buffers, self._numbers = tree.get("buffers", []), numbers

    def rows(self, number: int, width: int) -> Float[np.ndarray, "n width"]:
        """(n, width) float64.

        Raises:
            ValueError: no such accessor, another width, less data than it announces, a part in another file.
        """
        return self._array(number, width).astype(np.float64)

    def scalars(self, number: int) -> Int[np.ndarray, " n"]:
        """(n,) int64. Raises as `rows` does."""
        values = self._array(number, 1)
        if values.dtype.kind == "f":
            raise ValueError("its faces name vertices by numbers that are not whole")
        return values.ravel().astype(np.int64)

    def _array(self, number: int, width: int) -> np.ndarray:
        if not isinstance(number, int) or not 0 <= number < len(self._accessors):
            raise ValueError(f"it names accessor {number}, {len(self._accessors)} are there")
        accessor = self._accessors[number]
        kind, count = _TYPES.get(accessor.get("componentType")), accessor.get("count")
        if kind is None or _WIDTHS.get(accessor.get("type")) != width or not isinstance(count, int) or count < 0:
            raise ValueError(f"accessor {number} is not what its object needs: {str(accessor)[:80]}")
        if "bufferView" in accessor:
            values = self._view(accessor["bufferView"], accessor.get("byteOffset", 0), kind, count, width)
        elif "sparse" not in accessor:
            raise ValueError(f"accessor {number} has no numbers: they are compressed or missing")
        else:
            if count * width > max(1000, 100 * len(self._numbers)):
                raise ValueError(f"accessor {number} announces {count:,} rows, nothing backs them")
            values = np.zeros((count, width), dtype=kind)
        if "sparse" in accessor:
            values = self._changed(values, accessor["sparse"], kind, width)
        if accessor.get("normalized") and values.dtype.kind in "iu":
            most = np.iinfo(values.dtype).max
            values = np.maximum(values.astype(np.float64) / most, -1)
        return values

    def _view(self, number: int, offset: int, kind: str, count: int, width: int) -> np.ndarray:
        """(count, width) from a view of a buffer; rows may lie further apart than they are long."""
        if not isinstance(number, int) or not 0 <= number < len(self._views):
            raise ValueError(f"it names view {number}, {len(self._views)} are there")
        view = self._views[number]
        if "extensions" in view:
            raise ValueError(f"its numbers are compressed by {', '.join(view['extensions'])}, which is not read")
        data = self._buffer(view.get("buffer", 0))
        begin, length = view.get("byteOffset", 0), view.get("byteLength", 0)
        size = np.dtype(kind).itemsize * width
        step = view.get("byteStride", size)
        if min(begin, length, offset, step - size) < 0 or begin + length > len(data):
            raise ValueError(f"view {number} reaches behind the end of its buffer")
        if count and offset + step * (count - 1) + size > length:
            raise ValueError(f"an array announces {count:,} rows, {max(0, length - offset) // step:,} are there")
        raw = np.ndarray((count, width), kind, data, begin + offset, (step, np.dtype(kind).itemsize)) if count else []
        return np.array(raw, dtype=np.dtype(kind).newbyteorder("=")).reshape(count, width)

    def _changed(self, values: np.ndarray, sparse: dict, kind: str, width: int) -> np.ndarray:
        """With the rows that a sparse accessor puts in."""
        count, where, what = sparse["count"], sparse["indices"], sparse["values"]
        at = self._view(
            where["bufferView"], where.get("byteOffset", 0), _TYPES[where["componentType"]], count, 1
        ).ravel()
        if count and at.max() >= len(values):
            raise ValueError("a sparse array names a row that is not there")
        values[at.astype(np.int64)] = self._view(what["bufferView"], what.get("byteOffset", 0), kind, count, width)
        return values

    def _buffer(self, number: int) -> bytes:
        if not isinstance(number, int) or not 0 <= number < len(self._buffers):
            raise ValueError(f"it names buffer {number}, {len(self._buffers)} are there")
        uri = self._buffers[number].get("uri")
        if uri is None and number == 0:
            return self._numbers
        if uri is None or not uri.startswith("data:") or ";base64," not in uri:
            raise ValueError("its numbers lie in another file, which is not opened")
        try:
            return base64.b64decode(uri.split(";base64,", 1)[1], validate=True)
        except binascii.Error as error:
            raise ValueError(f"its numbers cannot be read: {error}") from None
