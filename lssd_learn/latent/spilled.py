"""Matrices of many shapes on the disk, where memory would not hold them: read and written a few shapes at a time."""

import tempfile
from collections.abc import Sequence

import numpy as np
import torch
from jaxtyping import Float
from torch import Tensor


class Spilled:
    """(n, r, k) float32 in a temporary file that nobody else sees and that is gone with this object, or a kill.

    `spilled[2:5] = tensor` writes, `spilled[2:5]`, `spilled[3]` and `spilled[[4, 0]]` read; `$TMPDIR` says where.

    Args:
        shape: (n, r, k).
        device: of the tensors that are read.
    """

    def __init__(self, shape: Sequence[int], device: torch.device | str = "cpu"):
        self.shape, self.device = tuple(shape), torch.device(device)
        self._file = tempfile.TemporaryFile()  # noqa: SIM115  it lives as long as this does
        self._entries = self.shape[1] * self.shape[2]

    def __setitem__(self, some: slice, values: Float[Tensor, "b r k"]) -> None:
        begin, end, _ = some.indices(self.shape[0])
        if tuple(values.shape) != (end - begin, *self.shape[1:]):
            raise ValueError(f"expected {(end - begin, *self.shape[1:])}, got {tuple(values.shape)}")
        self._file.seek(4 * begin * self._entries)
        values.detach().cpu().float().contiguous().numpy().tofile(self._file)

    def __getitem__(self, some: slice | int | Sequence[int]) -> Float[Tensor, "*b r k"]:
        if isinstance(some, slice):
            begin, end, _ = some.indices(self.shape[0])
            return self._read(begin, end - begin)
        if isinstance(some, int):
            return self._read(some, 1)[0]
        return torch.cat([self._read(int(i), 1) for i in some])

    def _read(self, begin: int, count: int) -> Tensor:
        self._file.seek(4 * begin * self._entries)
        array = np.fromfile(self._file, np.float32, count * self._entries)
        return torch.from_numpy(array.reshape(count, *self.shape[1:])).to(self.device)
