"""Which shapes lack a part that the others have: a scan that was cut off, a broken bone."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Int

# A shape lacks a part where so much more of the area of the others is not reached from it than of its own from them, in
# the median of its maps: what merely differs is not reached either way.
LACKS = 0.01


def lacking(n: int, edges: Int[np.ndarray, "m 2"], unreached: Sequence[tuple[float, float] | None]) -> list[int]:
    """The shapes that seem to lack a part that those they are mapped to have.

    Args:
        n: number of shapes.
        edges: (m, 2) of a network.
        unreached: of each edge the shares of area that are not reached, see `PairMaps.unreached`; None where nothing
            is known.
    """
    excess: list[list[float]] = [[] for _ in range(n)]
    for (i, j), shares in zip(edges.tolist(), unreached, strict=True):
        if shares is not None:
            excess[i].append(shares[1] - shares[0])
            excess[j].append(shares[0] - shares[1])
    return [i for i, some in enumerate(excess) if some and np.median(some) > LACKS]
