"""A few shapes that stand for many."""

import torch

from lssd_learn.errors import check_whole
from lssd_learn.operators.matrices import as_float64


def representatives(points, count: int = 1) -> list[int]:
    """Positions of the shapes nearest to the others: first the medoid, then each that shortens the way most.

    The way is the sum, over all shapes, of the Euclidean distance to the nearest of those chosen: the first step
    ("build") of the partition around medoids of Kaufman & Rousseeuw, "Finding Groups in Data" (1990).

    Args:
        points: (n, …) operators or features.
        count: how many; all, where there are fewer.

    Raises:
        InputError: a count below 1.
    """
    check_whole("count", count, 1)
    points = as_float64(points).flatten(1)
    distances = torch.cdist(points, points, compute_mode="donot_use_mm_for_euclid_dist")
    nearest, chosen = torch.full((len(points),), torch.inf), []
    for _ in range(min(count, len(points))):
        ways = torch.minimum(distances, nearest.to(distances)).sum(1)
        ways[chosen] = torch.inf
        chosen.append(int(ways.argmin()))
        nearest = torch.minimum(nearest.to(distances), distances[chosen[-1]])
    return chosen
