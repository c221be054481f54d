"""Operators as the vectors that a linear model is of: their logarithms, where what shapes do adds up."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float
from torch import Tensor

from lssd_learn.operators.matrices import restrict
from lssd_learn.operators.vectors import live_functions, log_vectors

TOGETHER = "+"  # between the names of kinds that are taken together


def model_vectors(
    operators: Float[Tensor, "n channels m m"], kinds: Sequence[str]
) -> dict[str, Float[np.ndarray, "n _"]]:
    """Kind → (n, r) vectors about their mean with the inner products of the logarithms of operators, r at most n.

    Of conformal operators they are taken on the functions that are not null, see `operators.matrices`. Of several kinds
    there are also all of them together, each scaled so that it varies as much as the others.

    Args:
        operators: of n shapes, a channel a kind.
        kinds: their names.

    Raises:
        InputError: as `log_vectors`.
    """
    live, found = live_functions(operators), {}
    for c, kind in enumerate(kinds):
        found[kind] = scores(log_vectors(restrict(operators[:, c], live[c])).cpu().numpy())
    if len(kinds) > 1:
        sizes = [np.linalg.norm(vectors) or 1.0 for vectors in found.values()]
        parts = [vectors / size for vectors, size in zip(found.values(), sizes, strict=True)]
        found[TOGETHER.join(kinds)] = scores(np.concatenate(parts, axis=1))
    return found


def scores(vectors: Float[np.ndarray, "n d"]) -> Float[np.ndarray, "n _"]:
    """Vectors about their mean in coordinates (n, min(n, d)) along their principal axes, the largest first."""
    U, sizes, Vt = np.linalg.svd(vectors - vectors.mean(0), full_matrices=False)
    return U * sizes * _signs(Vt)


def _signs(Vt: np.ndarray) -> np.ndarray:
    """An axis has no sign: its largest entry is taken as positive."""
    largest = Vt[np.arange(len(Vt)), np.abs(Vt).argmax(1)]
    return np.where(largest < 0, -1.0, 1.0)
