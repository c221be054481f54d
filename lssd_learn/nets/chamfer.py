"""Chamfer distance between clouds of points, with gradients: what a net that draws clouds is trained on.

Only who is nearest to whom needs a search, and that carries no gradient. The distances are then computed again from the
gathered pairs: nothing of the size N × M is ever built, and close points lose no digits. On a CPU the search goes
through k-d trees, on any other device through all pairs, a chunk at a time.
"""

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import torch
from jaxtyping import Float, Int
from numpy.typing import ArrayLike
from torch import Tensor

from lssd_learn.errors import InputError, check_whole
from lssd_learn.kdtree import cKDTree

SEARCHES = ("tree", "pairs")

# Distances held at once when all pairs are looked at: 128 MiB of them, and twice that for the differences.
PAIRS = 2**25


def chamfer(a: ArrayLike, b: ArrayLike, *, search: str | None = None, workers: int | None = None) -> Float[Tensor, ""]:
    """Mean squared distance from the points of a to the nearest of b, plus the same from b to a.

    Both means go over points and batch alike. Gradients flow to both clouds, through the pairs that are nearest.

    Args:
        a: (batch, N, 3), or (N, 3) for a single cloud; tensor or array.
        b: (batch, M, 3), or (M, 3); on the device of `a`.
        search: "tree" or "pairs"; None is trees on a CPU and pairs elsewhere.
        workers: threads that search, each a cloud at a time; None is as many as torch uses.

    Returns:
        A number, in squared units of length.

    Raises:
        InputError: clouds of other shapes, unequal batches, empty or not finite; an unknown search.

    Source: Fan, Su & Guibas, "A Point Set Generation Network for 3D Object Reconstruction from a Single Image", 2017.

    Examples:
        >>> import torch
        >>> import lssd_learn as lssd
        >>> a, b = torch.zeros(1, 1, 3), torch.full((1, 1, 3), 2.0)
        >>> float(lssd.chamfer(a, b))  # 12 there and 12 back
        24.0
    """
    a, b = _clouds(a, b, ("a", "b"))
    to_b, to_a = _search(a, b, search, workers, both=True)
    return _squares(a, b, to_b).mean() + _squares(b, a, to_a).mean()


def nearest_squares(
    queries: ArrayLike, points: ArrayLike, *, search: str | None = None, workers: int | None = None
) -> Float[Tensor, "*batch N"]:
    """Squared distance of every query to the nearest of the points: one direction of `chamfer`, not averaged.

    Args:
        queries: (batch, N, 3) or (N, 3).
        points: (batch, M, 3) or (M, 3).
        search, workers: as for `chamfer`.

    Returns:
        (batch, N) or (N,), with gradients, in squared units of length.

    Raises:
        InputError: as for `chamfer`.
    """
    single = np.ndim(queries) == 2
    queries, points = _clouds(queries, points, ("queries", "points"))
    (found,) = _search(queries, points, search, workers)
    squares = _squares(queries, points, found)
    return squares[0] if single else squares


def nearest(
    queries: ArrayLike, points: ArrayLike, *, search: str | None = None, workers: int | None = None
) -> Int[Tensor, "*batch N"]:
    """Which of the points is nearest to every query, (batch, N) or (N,) int64; arguments as for `nearest_squares`.

    Of several that are equally near, any.
    """
    single = np.ndim(queries) == 2
    queries, points = _clouds(queries, points, ("queries", "points"))
    (found,) = _search(queries, points, search, workers)
    return found[0] if single else found


def _squares(queries: Tensor, points: Tensor, found: Tensor) -> Tensor:
    """(batch, N) squared distances of the queries to the points that were found for them."""
    return (queries - points.gather(1, found[..., None].expand(-1, -1, 3))).square().sum(-1)


@torch.no_grad()
def _search(a: Tensor, b: Tensor, search: str | None, workers: int | None, both: bool = False) -> tuple[Tensor, ...]:
    """For every point of a the nearest of b (batch, N), and, if asked for, for every point of b the nearest of a."""
    if search is None:
        search = "tree" if a.device.type == "cpu" else "pairs"
    if search not in SEARCHES:
        raise InputError(f"search: expected one of {', '.join(SEARCHES)}, got {search!r}")
    if search == "pairs":
        return (_nearest_of_pairs(a, b), _nearest_of_pairs(b, a)) if both else (_nearest_of_pairs(a, b),)
    workers = torch.get_num_threads() if workers is None else workers
    check_whole("workers", workers, 1)
    clouds = [tensor.detach().double().cpu().numpy() for tensor in (a, b)]
    ask = _ask_both_ways if both else _ask
    if workers == 1 or len(a) == 1:
        found = list(map(ask, *clouds))
    else:
        with ThreadPoolExecutor(workers) as pool:  # threads: the searches let go of Python's lock
            found = list(pool.map(ask, *clouds))
    return tuple(torch.from_numpy(np.stack(indices)).to(a.device) for indices in zip(*found, strict=True))


def _ask(a: np.ndarray, b: np.ndarray) -> tuple[np.ndarray]:
    return (cKDTree(b).query(a)[1],)


def _ask_both_ways(a: np.ndarray, b: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    # Asked in the order of their own tree's leaves, neighbours one after the other, which saves a sixth of the time.
    # Trees of fixed clouds are not kept from one call to the next: making one is a tenth of the work.
    tree_a, tree_b = cKDTree(a), cKDTree(b)
    found = np.empty(len(a), dtype=np.int64), np.empty(len(b), dtype=np.int64)
    found[0][tree_a.indices] = tree_b.query(a[tree_a.indices])[1]
    found[1][tree_b.indices] = tree_a.query(b[tree_b.indices])[1]
    return found


def _nearest_of_pairs(queries: Tensor, points: Tensor) -> Tensor:
    """(batch, N) by looking at all pairs, from differences: a product of matrices would lose digits on close points."""
    rows = max(1, PAIRS // max(1, len(points) * points.shape[1]))
    found = []
    for chunk in queries.split(rows, dim=1):
        squares = (chunk[:, :, None, 0] - points[:, None, :, 0]).square_()
        for axis in (1, 2):
            across = chunk[:, :, None, axis] - points[:, None, :, axis]
            squares.addcmul_(across, across)
        found.append(squares.argmin(-1))
    return torch.cat(found, dim=1)


def _clouds(a: ArrayLike, b: ArrayLike, names: Sequence[str]) -> tuple[Tensor, Tensor]:
    """Both as (batch, points, 3) tensors of one floating type, checked."""
    tensors = []
    for values, name in zip((a, b), names, strict=True):
        # A copy of an array: torch does not take those that nobody may write to.
        tensor = values if isinstance(values, Tensor) else torch.tensor(np.asarray(values))
        if tensor.ndim not in (2, 3) or tensor.shape[-1] != 3 or tensor.numel() == 0:
            wanted = "(batch, points, 3) or (points, 3) with at least one point"
            raise InputError(f"{name}: expected {wanted}, got {tuple(tensor.shape)}")
        if not tensor.isfinite().all():
            raise InputError(f"{name}: expected finite points, {int((~tensor.isfinite()).sum())} coordinates are not")
        tensors.append(tensor)
    one, other = tensors
    if one.ndim != other.ndim or (one.ndim == 3 and len(one) != len(other)) or one.device != other.device:
        both = " and ".join(f"{tuple(tensor.shape)} on {tensor.device}" for tensor in tensors)
        raise InputError(f"{names[0]}, {names[1]}: expected as many clouds on the same device, got {both}")
    # Half precision would not tell the points of a surface apart.
    kind = torch.promote_types(torch.promote_types(one.dtype, other.dtype), torch.float32)
    one, other = one.to(kind), other.to(kind)
    return (one[None], other[None]) if one.ndim == 2 else (one, other)
