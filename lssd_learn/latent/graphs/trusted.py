"""Which edges of a network to keep where some of its maps are not to be trusted."""

import numpy as np
from jaxtyping import Bool, Float, Int
from scipy.sparse import csr_array
from scipy.sparse.csgraph import minimum_spanning_tree


def trusted(
    n: int, edges: Int[np.ndarray, "m 2"], qualities: Float[np.ndarray, " m"], level: float
) -> tuple[Bool[np.ndarray, " m"], Int[np.ndarray, " b"]]:
    """The edges that are good enough, and the best of the others where the network would fall apart without them.

    Args:
        n: number of shapes.
        edges: of a connected network.
        qualities: of the maps on them, in [0, 1]; NaN where nothing is known, which is trusted.
        level: that a map has to reach.

    Returns:
        A mask of the edges that stay, and the numbers of those of them that are below the level, the worst first.
    """
    known = np.where(np.isnan(qualities), 1.0, qualities)
    good = known >= level
    # A spanning tree of the best maps: the good ones alike, so that none of the others is in it but where it has to be.
    costs = np.where(good, 1.0, 3.0 - known)
    ends = edges.T.astype(np.int32)  # the numbers that scipy before 1.17 wants in a graph
    tree = minimum_spanning_tree(csr_array((costs, tuple(ends)), shape=(n, n))).tocoo()
    number = {(min(i, j), max(i, j)): e for e, (i, j) in enumerate(edges.tolist())}
    in_tree = [number[min(i, j), max(i, j)] for i, j in zip(tree.row.tolist(), tree.col.tolist(), strict=True)]
    bridges = np.array([e for e in in_tree if not good[e]], dtype=np.int64)
    kept = good.copy()
    kept[bridges] = True
    return kept, bridges[np.argsort(known[bridges], kind="stable")]
