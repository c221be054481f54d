"""Which shapes lack a part that the others have: a scan that was cut off, a broken bone."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Int

# A shape lacks a part where so much more of the area of the others is not reached from it than of its own from them, in
# the median of its maps: what merely differs is not reached either way.
LACKS = 0.01


def lacking(n: int, edges: Int[np.ndarray, "m 2"], unreached: Sequence[tuple[float, float] | None]) -> list[int]:
    """The shapes that seem to lack a part that those they are mapped to have.

    The worst is found first, and its maps tell nothing of the others: beside a shape that lacks much, one that lacks
    little seems whole.

    Args:
        n: number of shapes.
        edges: (m, 2) of a network.
        unreached: of each edge the shares of area that are not reached, see `PairMaps.unreached`; None where nothing
            is known.
    """
    excess: list[dict[int, float]] = [{} for _ in range(n)]
    for (i, j), shares in zip(edges.tolist(), unreached, strict=True):
        if shares is not None:
            excess[i][j], excess[j][i] = shares[1] - shares[0], shares[0] - shares[1]
    medians = {i: float(np.median(list(some.values()))) for i, some in enumerate(excess) if some}
    found = []
    while medians and medians[worst := max(medians, key=lambda i: medians[i])] > LACKS:
        found.append(worst)
        del medians[worst]
        for other in excess[worst]:
            excess[other].pop(worst)
            if other in medians:
                left = list(excess[other].values())
                medians[other] = float(np.median(left)) if left else 0.0
    return sorted(found)
