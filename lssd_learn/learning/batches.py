"""Batches of tensors that lie in memory: what `ShapeData` hands to Lightning in place of a torch DataLoader.

A DataLoader fetches samples one by one and collates them, which for operators of a few kilobytes costs more than the
training step. Here a batch is one index into a tensor.
"""

import math
from collections.abc import Iterator

import numpy as np
import torch
from torch import Tensor


class Order:
    """The positions of each batch of an epoch.

    The order of epoch e follows from (seed, e) alone, so a resumed run sees the batches an uninterrupted one sees.
    With `world` processes each takes an equal share of every batch: the gradient, their mean, is that of the whole
    batch, however many there are. A batch that does not divide is filled up with its own first samples.

    Args:
        n: number of samples.
        batch: samples a batch, over all processes; the last batch may be smaller.
        seed: of the order; None keeps the samples as they lie.
        rank, world: which of how many processes this is.
    """

    def __init__(self, n: int, batch: int, seed: int | None = None, rank: int = 0, world: int = 1):
        self.n, self.batch, self.seed, self.rank, self.world = n, batch, seed, rank, world
        self.epoch = 0

    def set_epoch(self, epoch: int) -> None:
        """Lightning calls this before every epoch."""
        self.epoch = epoch

    def __len__(self) -> int:
        return math.ceil(self.n / self.batch)

    def __iter__(self) -> Iterator[Tensor]:
        order = (
            np.arange(self.n)
            if self.seed is None
            else np.random.default_rng((self.seed, self.epoch)).permutation(self.n)
        )
        for whole in torch.from_numpy(order).split(self.batch):
            share = math.ceil(len(whole) / self.world)
            yield whole.repeat(math.ceil(share * self.world / len(whole)))[self.rank : share * self.world : self.world]


class Batches:
    """Iterates over tuples of batches of `tensors` (equal length) in the order of `sampler`."""

    def __init__(self, sampler: Order, *tensors: Tensor):
        # The names of a DataLoader, under which Lightning looks for set_epoch.
        self.sampler, self.batch_sampler = sampler, None
        self.tensors = tensors

    def __len__(self) -> int:
        return len(self.sampler)

    def __iter__(self) -> Iterator[tuple[Tensor, ...]]:
        for positions in self.sampler:
            yield tuple(tensor[positions] for tensor in self.tensors)
