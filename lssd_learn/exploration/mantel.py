"""Whether two ways to look at the same shapes tell them apart alike."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from lssd_learn.errors import InputError, check_whole


class Mantel(NamedTuple):
    """Pearson's correlation of the distances between every two shapes, and the chance of one as large."""

    correlation: float
    p: float


def mantel(
    first: Float[np.ndarray, "n n"], second: Float[np.ndarray, "n n"], permutations: int = 999, seed: int = 0
) -> Mantel:
    """Mantel's test of two matrices of distances: shapes of one are permuted.

    Args:
        first, second: symmetric (n, n).
        permutations: at random, beside the order as it is.
        seed: of these.

    Raises:
        InputError: fewer than four shapes, distances that are all the same.

    Reference:
        Mantel, "The detection of disease clustering and a generalized regression approach", Cancer Research 27 (1967).
    """
    check_whole("permutations", permutations, 1)
    n = len(first)
    if n < 4 or first.shape != second.shape:
        raise InputError(f"distances: expected those of the same four shapes or more, got {len(first)}, {len(second)}")
    pairs = np.triu_indices(n, 1)
    a, b = (one - one[pairs].mean() for one in (first, second))
    scale = np.linalg.norm(a[pairs]) * np.linalg.norm(b[pairs])
    if not scale > 1e-12 * n * n * max(np.abs(first).max() * np.abs(second).max(), np.finfo(float).tiny):
        raise InputError("distances: expected some that differ")
    rng, found = np.random.default_rng(seed), np.empty(permutations + 1)
    for k in range(permutations + 1):
        order = rng.permutation(n) if k else np.arange(n)
        found[k] = a[pairs] @ b[np.ix_(order, order)][pairs] / scale
    return Mantel(float(found[0]), float((found >= found[0] - 1e-12).mean()))


def distances(vectors: Float[np.ndarray, "n d"]) -> Float[np.ndarray, "n n"]:
    """(n, n) Euclidean distances of n vectors."""
    squares = np.square(vectors).sum(1)
    found = squares[:, None] + squares - 2 * vectors @ vectors.T
    np.fill_diagonal(found, 0.0)
    return np.sqrt(np.maximum(found, 0))
