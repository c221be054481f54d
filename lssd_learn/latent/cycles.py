"""How far the maps of a network are from agreeing with each other, edge by edge: what its weights "cycle" are made of.

A map that is mirrored both ways undoes itself. Round a triangle of edges it does not, unless others are mirrored too.
"""

from collections.abc import Callable, Sequence

import numpy as np
from jaxtyping import Float, Int
from torch import Tensor

from lssd_learn.maps import cycle_error

MOST = 15  # triangles of an edge that are looked at
BETWEEN = 2  # times as many functions are carried on between two maps as are compared in the end


def cycle_errors(
    pairs: Int[np.ndarray, "m 2"], maps: Callable[[int, int], np.ndarray | Tensor], k: int
) -> Float[np.ndarray, " m"]:
    """(m,) of each edge the median of ‖C_ki C_jk C_ij − I‖ over the triangles i, j, k that it is in, round both ways.

    Of an even number of triangles it is the lower median: one other bad edge shall not count against it. Where there
    are many triangles some are taken, spread over them. An edge in no triangle has the mean of ‖C_ji C_ij − I‖ and
    ‖C_ij C_ji − I‖ in its place.

    Args:
        pairs: (m, 2) edges i < j.
        maps: (i, j) → C_ij, for both directions of every edge.
        k: so many of the lowest functions are compared.
    """
    kept = {}
    neighbours: dict[int, set[int]] = {}
    for i, j in pairs.tolist():
        for a, b in ((i, j), (j, i)):
            kept[a, b] = np.asarray(maps(a, b))[: BETWEEN * k, : BETWEEN * k]
            neighbours.setdefault(a, set()).add(b)
    errors = []
    for i, j in pairs.tolist():
        thirds = sorted(neighbours[i] & neighbours[j])
        some = np.unique(np.linspace(0, len(thirds) - 1, min(MOST, len(thirds))).round().astype(int))
        cycles = [(i, j, thirds[t]) for t in some] or [(i, j)]
        each = sorted((_error(kept, cycle, k) + _error(kept, cycle[::-1], k)) / 2 for cycle in cycles)
        errors.append(each[(len(each) - 1) // 2])
    return np.array(errors)


def _error(kept: dict[tuple[int, int], np.ndarray], cycle: Sequence[int], k: int) -> float:
    """‖… − I‖ of the maps round a cycle."""
    maps = [kept[pair] for pair in zip(cycle, [*cycle[1:], cycle[0]], strict=True)]
    return cycle_error(maps[0][:, :k], *maps[1:-1], maps[-1][:k])
