"""The nearest points of every point of a cloud, and the largest value among them: what an edge convolution is made of.

A cloud of 1,024 points has a million pairs of points, so they are gone through a cloud at a time and nothing of that
size is kept, let alone a number for each pair and feature.
"""

import torch
from jaxtyping import Float, Int
from torch import Tensor

# Points that are worked on at once on CPU: what belongs to them then stays in a core's cache.
CHUNK = 1024

# Numbers that are first compared by their maximum, see `_largest`.
GROUP = 8


@torch.no_grad()
def neighbour_graph(points: Float[Tensor, "n points channels"], k: int) -> Int[Tensor, "rows k"]:
    """The k nearest points of every point of its cloud by Euclidean distance, itself among them.

    Args:
        points: (n, points, channels): coordinates or features.
        k: at most as many as there are points.

    Returns:
        (n · points, k) rows of `points.flatten(0, 1)`, in no order.
    """
    n, many, _ = points.shape
    graph = torch.empty(n, many, k, dtype=torch.long, device=points.device)
    step = max(1, CHUNK // many) if points.device.type == "cpu" else max(1, n)
    for i in range(0, n, step):
        some = points[i : i + step]
        # −½|x_i − x_j|² less −½|x_i|², which is the same for all j.
        closeness = torch.baddbmm(-0.5 * some.square().sum(-1).unsqueeze(1), some, some.mT)
        graph[i : i + step] = _largest(closeness, k)
    return (graph + many * torch.arange(n, device=points.device).view(n, 1, 1)).flatten(0, 1)


def _largest(values: Tensor, k: int) -> Tensor:
    """(…, k) indices of the k largest of each row of (…, m) values, in no order.

    They lie in the k groups with the largest maxima, for each of these holds one number at least that is as large as
    any outside. So most are never sorted, which is more than twice as fast as `topk`.
    """
    m = values.shape[-1]
    if m % GROUP or m < 2 * GROUP * k:
        return values.topk(k, sorted=False).indices
    # Group g holds every (m / GROUP)-th number from g on: a maximum over rows, which is the fast way.
    groups = values.unflatten(-1, (GROUP, m // GROUP))
    chosen = groups.amax(-2).topk(k, sorted=False).indices
    candidates = groups.gather(-1, chosen.unsqueeze(-2).expand(*groups.shape[:-1], k)).flatten(-2)
    places = candidates.topk(k, sorted=False).indices
    return places // k * (m // GROUP) + chosen.gather(-1, places % k)


def neighbours_maximum(
    values: Float[Tensor, "n points features"], graph: Int[Tensor, "rows k"]
) -> Float[Tensor, "n points features"]:
    """Each feature's largest value among the neighbours of a point; gradient flows to the neighbour that has it.

    Args:
        values: (n, points, features).
        graph: (n · points, k) from `neighbour_graph`.

    Returns:
        (n, points, features).
    """
    rows = values.flatten(0, 1)
    return rows.gather(0, _winners(rows, graph)).view_as(values)


@torch.no_grad()
def _winners(rows: Tensor, graph: Tensor) -> Tensor:
    """(m, features) the row of `rows`, (m, features), that is largest among those which `graph`, (m, k), names."""
    k = graph.shape[1]
    winners = torch.empty_like(rows, dtype=torch.long)
    # The first of the largest, by a maximum of small numbers: `max(1).indices` takes twice as long.
    rank = torch.arange(k - 1, -1, -1, dtype=torch.int16, device=rows.device).unsqueeze(1)
    step = max(1, CHUNK // 4) if rows.device.type == "cpu" else max(1, len(rows))
    for i in range(0, len(rows), step):
        some = graph[i : i + step]
        rivals = rows.index_select(0, some.flatten()).unflatten(0, some.shape)
        places = k - 1 - ((rivals == rivals.amax(1, keepdim=True)) * rank).amax(1)
        winners[i : i + step] = some.gather(1, places.long())
    return winners
