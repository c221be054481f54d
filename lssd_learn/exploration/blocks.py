"""Shapes that belong together, such as the scans of one person, and how a grouping of them may be permuted.

Labels that are handed out at random could have come otherwise only where shapes can be exchanged: whole blocks for
blocks as large, where all shapes of a block are of one group; the shapes of a block among themselves, where it has
several groups.

Source: Winkler, Webster, Vidaurre, Nichols & Smith, "Multi-level block permutation", NeuroImage 123 (2015).
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product
from math import factorial, prod

import numpy as np
import torch
from jaxtyping import Bool, Float, Int

from lssd_learn.errors import InputError
from lssd_learn.exploration.pairs import group_codes


@dataclass(frozen=True)
class Design:
    """What may be exchanged for what under a grouping in which n shapes have labels 0, 1, …

    Attributes:
        codes: (n,) int64, the grouping.
        blocks: (n,) int64, which block each shape is of.
        exchanges: each (u, s) int64 positions: u units of s shapes, a unit of one label, which pass labels around.
        varied: (n,) bool: the shapes of blocks with several groups.
        still: how many blocks of one group can be exchanged for none of another.
    """

    codes: Int[np.ndarray, " n"]
    blocks: Int[np.ndarray, " n"]
    exchanges: list[Int[np.ndarray, "_ _"]]
    varied: Bool[np.ndarray, " n"]
    still: int

    @classmethod
    def of(cls, codes: np.ndarray, blocks: np.ndarray | None = None) -> "Design":
        """Without blocks every shape may be exchanged for every other.

        Raises:
            InputError: nothing can be exchanged.
        """
        n = len(codes)
        if blocks is None:
            return cls(codes, np.arange(n), [np.arange(n)[:, None]], np.zeros(n, dtype=bool), 0)
        members = [np.flatnonzero(blocks == b) for b in np.unique(blocks)]
        several = [some for some in members if len(set(codes[some])) > 1]
        whole = [some for some in members if len(set(codes[some])) == 1]
        sizes = sorted({len(some) for some in whole})
        alike = [np.array([some for some in whole if len(some) == size]) for size in sizes]
        moving = [units for units in alike if len(set(codes[units[:, 0]])) > 1]
        varied = np.isin(np.arange(n), np.concatenate([*several, np.empty(0, dtype=int)]))
        still = len(whole) - sum(map(len, moving))
        if not several and not moving:
            told = ", ".join(f"{len(units)} of {size}" for size, units in zip(sizes, alike, strict=True))
            raise InputError(
                "blocks: expected blocks of several groups, or blocks of as many shapes in two groups; there is nothing"
                f" to permute in {len(whole)} blocks ({told} shapes)"
            )
        return cls(codes, blocks, [*moving, *(some[:, None] for some in several)], varied, still)

    @classmethod
    def of_labels(cls, labels: Sequence, blocks: Sequence | None = None) -> "Design":
        """Of n labels and those of their blocks; a shape without a label (None, "" or nan) plays no part."""
        codes, _ = group_codes(labels, len(labels))
        known = (codes >= 0).numpy()
        return cls.of(codes.numpy()[known], None if blocks is None else block_codes(blocks, len(codes))[known])

    def __str__(self) -> str:
        several = [units for units in self.exchanges if self.varied[units[0, 0]]]
        parts = []
        if moving := [units for units in self.exchanges if not self.varied[units[0, 0]]]:
            sizes = ", ".join(str(units.shape[1]) for units in moving)
            parts.append(f"{sum(map(len, moving))} blocks exchanged whole for blocks as large ({sizes} shapes)")
        if several:
            parts.append(f"{len(several)} blocks with several groups permuted within")
        if self.still:
            parts.append(f"{self.still} blocks kept as they are, since none of another group is as large")
        return "; ".join(parts)

    @property
    def count(self) -> int:
        """How many groupings there are."""
        return prod(_arrangements(self.codes[units[:, 0]]) for units in self.exchanges)

    def groupings(self, permutations: int, seed: int) -> tuple[Int[np.ndarray, "N n"], bool]:
        """(N, n) groupings, that of the design first, and whether they are all there are, each once: if these are few.

        Args:
            permutations: how many at random beside the first, where there are more.
            seed: of the random ones.
        """
        if self.count <= permutations:
            found = np.tile(self.codes, (self.count, 1))
            all_of = [list(_distinct(self.codes[units[:, 0]].tolist())) for units in self.exchanges]
            for row, chosen in zip(found, product(*all_of), strict=True):
                for units, labels in zip(self.exchanges, chosen, strict=True):
                    row[units] = np.array(labels)[:, None]
            own = (found == self.codes).all(1)
            return np.concatenate([found[own], found[~own]]), True
        found, rng = np.tile(self.codes, (1 + permutations, 1)), np.random.default_rng(seed)
        for units in self.exchanges:
            labels = rng.permuted(np.tile(self.codes[units[:, 0]], (permutations, 1)), axis=1)
            found[1:, units] = labels[:, :, None]
        return found, False

    def contrasts(self) -> list[tuple[int, int]]:
        """Pairs of groups (g, h) that two blocks or more have both of."""
        groups = range(self.codes.max() + 1)
        has = {g: set(self.blocks[self.codes == g]) for g in groups}
        return [(g, h) for g in groups for h in groups if g < h and len(has[g] & has[h]) > 1]


def within_blocks(D: Float[torch.Tensor, "n m m"], labels: Sequence, blocks: Sequence) -> Float[torch.Tensor, "n m m"]:
    """Operators (n, m, m) in which blocks with several groups differ by nothing but what differs within them.

    The mean of such a block is replaced by that of all shapes; blocks of one group stay as they are.

    Args:
        D: (n, m, m) operators.
        labels: n of groups, None for a shape without.
        blocks: n labels of blocks.
    """
    codes, of = group_codes(labels, len(D))[0].numpy(), block_codes(blocks, len(D))
    moved, mean = D.clone(), D.mean(0)
    for block in np.unique(of):
        if len(set(codes[(of == block) & (codes >= 0)])) > 1:
            some = torch.from_numpy(of == block)
            moved[some] = D[some] - D[some].mean(0) + mean
    return moved


def block_codes(blocks: Sequence, n: int) -> Int[np.ndarray, " n"]:
    """(n,) int64 the block of each shape; one without a label ("", None, nan) is a block of its own."""
    codes, count = group_codes(blocks, n)
    codes = codes.numpy()
    return np.where(codes < 0, count + np.arange(n), codes)


def paired_energies(
    D: Float[torch.Tensor, "n m m"], design: Design, groupings: Int[np.ndarray, "N n"]
) -> Float[torch.Tensor, " N"]:
    """(N,) how large the mean difference within blocks is: ‖mean of d_b‖² less what chance adds to it.

    d_b is the difference of the means of two groups within block b, and the statistic the mean of ⟨d_b, d_c⟩ over
    pairs of two blocks: 0 on average where there is nothing. (Of several pairs of groups it is the mean.) Of pairs, two
    shapes a block, permuting within blocks flips the signs of the d_b. What blocks differ by plays no part.

    Args:
        D: (n, m, m) operators.
        design: with blocks that have both groups.
        groupings: (N, n) of `Design.groupings`.
    """
    flat = D.flatten(1)
    flat = flat - flat.mean(0)
    same = torch.from_numpy(design.blocks[:, None] == design.blocks)
    products = torch.where(same.to(D.device), 0.0, flat @ flat.T)
    contrasts, total = design.contrasts(), D.new_zeros(len(groupings))
    for g, h in contrasts:
        weights = np.zeros(groupings.shape)
        both = [b for b in np.unique(design.blocks) if {g, h} <= set(design.codes[design.blocks == b])]
        for b in both:
            for group, sign in ((g, 1), (h, -1)):  # as many in every grouping
                size = np.sum((design.blocks == b) & (design.codes == group))
                weights += ((groupings == group) & (design.blocks == b)) * (sign / size)
        c = torch.from_numpy(weights).to(D)
        total = total + ((c @ products) * c).sum(1) / (len(both) * (len(both) - 1))
    return total / len(contrasts)


def _arrangements(labels: np.ndarray) -> int:
    return factorial(len(labels)) // prod(factorial(int(many)) for many in np.unique(labels, return_counts=True)[1])


def _distinct(labels: Sequence[int]) -> Iterator[tuple[int, ...]]:
    """Every different order of labels, once."""
    if not labels:
        yield ()
    for first in sorted(set(labels)):
        rest = list(labels)
        rest.remove(first)
        yield from ((first, *others) for others in _distinct(rest))
