"""Which shapes are trained on, which choose the epoch, which are the test."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from jaxtyping import Int
from numpy.typing import ArrayLike

from lssd_learn.errors import InputError, check_whole

# Of the paper, "Data-generation".
FRACTIONS = {"train": 0.75, "test": 0.15, "validation": 0.10}


@dataclass(frozen=True)
class Split:
    """Positions in a collection, int64. Those `split` makes are ascending, disjoint, and together the collection."""

    train: Int[np.ndarray, " t"]
    test: Int[np.ndarray, " u"]
    validation: Int[np.ndarray, " v"]

    def items(self):
        """(name, positions) of the three."""
        return vars(self).items()


def split(
    n: int,
    seed: int,
    fractions: Mapping[str, float] = FRACTIONS,
    held_out: ArrayLike | None = None,
    blocks: ArrayLike | None = None,
) -> Split:
    """Split n shapes at random, without regard to groups but for one that may be held out, or for blocks.

    Args:
        n: number of shapes.
        seed: the same n, seed and fractions always give the same split.
        fractions: of train, test and validation, summing to 1. Test and validation are rounded, train is the rest:
            400 shapes become 300, 60 and 40.
        held_out: positions of the shapes that are the test, all of them; the others are split into train and
            validation in the proportion of these two fractions. None draws the test at random as well.
        blocks: (n,) numbers of what belongs together and stands on one side: whole blocks are drawn, as many as come
            nearest to the fractions and one at least. Shapes held out are whole blocks. None is every shape by itself.

    Raises:
        InputError: fractions that are not three parts of 1, a negative seed, too few shapes or blocks.
    """
    parts = fractions.values()
    # Asked this way round, so that nan does not pass.
    if set(fractions) != set(FRACTIONS) or not (all(f > 0 for f in parts) and abs(sum(parts) - 1) <= 1e-6):
        came = ", ".join(f"{part} {fraction}" for part, fraction in fractions.items())
        raise InputError(f"split wants train, test and validation, each over 0 and in sum 1, got {came}")
    check_whole("seed", seed, 0)
    if blocks is not None:
        return _split_blocks(np.asarray(blocks), np.random.default_rng(seed), dict(fractions), held_out)
    order = np.random.default_rng(seed).permutation(n)
    if held_out is None:
        test = round(n * fractions["test"])
        validation = round(n * fractions["validation"])
    else:
        out = np.isin(order, held_out)
        order, test = np.concatenate([order[out], order[~out]]), int(out.sum())
        validation = round((n - test) * fractions["validation"] / (fractions["train"] + fractions["validation"]))
    if min(test, validation, n - test - validation) < 1:
        raise InputError(f"{n} shapes are too few to split into {dict(fractions)}: every part needs one at least")
    parts = np.split(order, [test, test + validation])
    return Split(test=np.sort(parts[0]), validation=np.sort(parts[1]), train=np.sort(parts[2]))


def _split_blocks(
    blocks: np.ndarray, rng: np.random.Generator, fractions: Mapping[str, float], held_out: ArrayLike | None
) -> Split:
    names, sizes = np.unique(blocks, return_counts=True)
    order = rng.permutation(len(names))
    if held_out is None:
        test, rest = _first(order, sizes, fractions["test"] * len(blocks), 2)
    else:
        out = np.isin(names[order], blocks[np.asarray(held_out)])
        test, rest = order[out], order[~out]
    left = sizes[rest].sum() * fractions["validation"] / (fractions["train"] + fractions["validation"])
    validation, train = _first(rest, sizes, left, 1)
    if not (len(test) and len(validation) and len(train)):
        raise InputError(f"{len(names)} blocks are too few to split into {fractions}: every part needs one at least")
    parts = {"train": train, "test": test, "validation": validation}
    return Split(**{name: np.flatnonzero(np.isin(blocks, names[some])) for name, some in parts.items()})


def _first(order: np.ndarray, sizes: np.ndarray, wanted: float, others: int) -> tuple[np.ndarray, np.ndarray]:
    """The first blocks in this order whose shapes are nearest to so many, one at least, and those after them, as many
    as `others` at least if there are."""
    most = max(1, len(order) - others)
    reached = np.cumsum(sizes[order[:most]])
    take = int(np.abs(reached - wanted).argmin()) + 1
    return order[:take], order[take:]
