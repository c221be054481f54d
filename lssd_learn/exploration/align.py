"""Which shape of one collection is which of another, without any map between the two."""

import math
from dataclasses import dataclass

import torch
from jaxtyping import Float
from scipy.optimize import linear_sum_assignment
from torch import Tensor

from lssd_learn.errors import InputError, check_positive
from lssd_learn.operators import log_eigenvalues
from lssd_learn.operators.matrices import as_operators


@dataclass(frozen=True)
class Alignment:
    """`pairs` (p, 2) int64, a shape of the first collection and its partner in the second, and `costs` (p,) of each.

    p is the size of the smaller collection, or less where shapes may stay alone; pairs are ordered by the first.
    """

    pairs: Tensor
    costs: Tensor


def align(first, second, unmatched: float | None = None) -> Alignment:
    """Pair two collections so that the shapes of a pair differ in the same way from those of their own collection.

    Each shape is described in its own latent space (see `descriptors`); the pairing has the least sum of Euclidean
    distances. The collections should vary alike, cats and dogs in the same poses, since what describes a shape is its
    deviation from the mean of its class.

    Args:
        first, second: area operators (n, m, m), as many functions in both; or (n, channels, m, m), area and conformal.
        unmatched: a pair whose distance is more than so many times the median distance to the nearest of the other
            collection is none: the sum to be least is that of the pairs, and of this limit for each pair given up.
            None pairs all that can be paired.

    Raises:
        InputError: as `descriptors`; or the descriptors of the two have different lengths; `unmatched` is not
            above 0.

    Source: "Base-shape independence" in the paper.
    """
    if unmatched is not None:
        check_positive("unmatched", unmatched)
    x, y = descriptors(first), descriptors(second)
    if x.shape[1] != y.shape[1]:
        raise InputError(f"align: expected as many functions in both collections, got {x.shape[1]} and {y.shape[1]}")
    costs = torch.cdist(x, y.to(x), compute_mode="donot_use_mm_for_euclid_dist").cpu()
    limit = math.inf
    if unmatched is not None:
        smaller = costs if len(x) <= len(y) else costs.T
        limit = unmatched * float(smaller.amin(1).median())
    excess = costs if limit == math.inf else (costs - limit).clamp(max=0)
    rows, columns = (torch.from_numpy(index) for index in linear_sum_assignment(excess.numpy()))
    paired = costs[rows, columns] <= limit
    rows, columns = rows[paired], columns[paired]
    return Alignment(torch.stack([rows, columns], dim=1), costs[rows, columns])


def descriptors(D) -> Float[Tensor, "n d"]:
    """Sorted log-eigenvalues less their mean over the collection (n, d) float64, the channels beside each other.

    They depend on no basis, so that shapes of different latent spaces can be compared. Null functions are left out.

    Args:
        D: (n, m, m) or (n, channels, m, m) symmetric operators, positive definite on their live functions.

    Raises:
        InputError: another shape, operators of which there is no logarithm.
    """
    D = as_operators("D", D)
    if D.ndim not in (3, 4) or 0 in D.shape:
        raise InputError(f"D: expected operators (n, m, m) or (n, channels, m, m), got {tuple(D.shape)}")
    channels = D[:, None] if D.ndim == 3 else D
    logs = torch.cat([log_eigenvalues(channels[:, c]) for c in range(channels.shape[1])], dim=1)
    return logs - logs.mean(0)
