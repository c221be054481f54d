"""Energies of all pairs of shapes, within groups and across them, without a loop over pairs.

With Δ = D_i − D_j, of unordered pairs, each counted once, and S = Σ D:

    within a set S:   Σ ΔᵀΔ = |S| Σ DᵀD − SᵀS
    across A and B:   Σ ΔᵀΔ = |B| Σ_A DᵀD + |A| Σ_B DᵀD − S_AᵀS_B − S_BᵀS_A

Of several groups these are summed over the groups, and over the pairs of groups.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import torch
from jaxtyping import Float, Int
from torch import Tensor
from torch.nn import functional

from lssd_learn.errors import InputError
from lssd_learn.operators.matrices import as_operators

CHUNK = 1024  # operators at a time


@dataclass(frozen=True)
class PairEnergies:
    """Sums or means of ΔᵀΔ over pairs: αᵀEα is how much nearer the pairs come when α is suppressed (`delta_energy`).

    Attributes:
        within, across: (…, m, m) symmetric positive semi-definite, pairs of one group and pairs of two.
        within_pairs, across_pairs: how many.
    """

    within: Float[Tensor, "*N m m"]
    across: Float[Tensor, "*N m m"]
    within_pairs: int
    across_pairs: int


def pair_energies(D, labels: Sequence, mean: bool = False) -> PairEnergies:
    """The energies of n shapes in two groups or more.

    Args:
        D: (n, m, m) operators.
        labels: n of them; None, "" or nan is a shape that is in no group, and plays no part.
        mean: the mean over pairs in each group (of two shapes at least) and in each pair of groups, and the mean of
            these, so that groups count the same whatever their sizes; else the sum over all pairs.

    Raises:
        InputError: a wrong number of labels, fewer than two groups.
    """
    D = as_stack("D", D)
    codes, count = group_codes(labels, len(D))
    if count < 2:
        raise InputError(f"labels: expected two groups or more, got {count}")
    known = codes >= 0
    if not known.all():
        D, codes = D[known], codes[known]
    return coded_energies(D, codes, count, mean)


def coded_energies(
    D: Float[Tensor, "n m m"], codes: Int[Tensor, "... n"], count: int, mean: bool = False
) -> PairEnergies:
    """The same for groups 0 … count − 1 in `codes` (…, n), many groupings of the same sizes at once."""
    n, m, _ = D.shape
    member = functional.one_hot(codes.to(D.device), count).to(D)
    sizes = member.reshape(-1, n, count)[0].sum(0)[:, None, None]
    # Differences do not know the mean; without it nothing cancels.
    mean_operator = D.mean(0)
    if codes.ndim == 1:
        each = [sums_about(mean_operator, D, codes.to(D.device) == g) for g in range(count)]
        S, P = (torch.stack(sums) for sums in zip(*each, strict=True))
    else:  # many groupings share the n products
        D = D - mean_operator
        S = (member.mT @ D.flatten(1)).unflatten(-1, (m, m))
        P = (member.mT @ (D.mT @ D).flatten(1)).unflatten(-1, (m, m))
    pairs = sizes * (sizes - 1) / 2
    # A pair within group g weighs w_g, one across g and h u_g u_h.
    w, u, couples = torch.ones_like(sizes), torch.ones_like(sizes), 1
    if mean:
        w = torch.where(pairs > 0, 1 / pairs.clamp(min=1) / (pairs > 0).sum().clamp(min=1), 0)
        u, couples = 1 / sizes, count * (count - 1) / 2
    within = (w * (sizes * P - S.mT @ S)).sum(-3)
    uS = u * S
    whole = uS.sum(-3)
    others = (u * sizes).sum() - u * sizes
    across = ((others * u * P).sum(-3) - whole.mT @ whole + (uS.mT @ uS).sum(-3)) / couples
    within_pairs = int(pairs.sum())
    return PairEnergies(within, across, within_pairs, n * (n - 1) // 2 - within_pairs)


def sums_about(
    centre: Float[Tensor, "m m"], D: Float[Tensor, "n m m"], chosen: Tensor | None = None
) -> tuple[Float[Tensor, "m m"], Float[Tensor, "m m"]]:
    """Σ Δ and Σ ΔᵀΔ (m, m) of Δ = D − centre, of operators D (n, m, m), or of the `chosen` (n,) of them.

    Some at a time, so that nothing of the size of D is made beside it, and all their rows in one product.
    """
    total, squares = torch.zeros_like(centre), torch.zeros_like(centre)
    for start in range(0, len(D), CHUNK):
        some = D[start : start + CHUNK]
        away = (some if chosen is None else some[chosen[start : start + CHUNK]]) - centre
        rows = away.flatten(0, 1)
        total += away.sum(0)
        squares += rows.mT @ rows
    return total, squares


def group_codes(labels: Sequence, n: int) -> tuple[Int[Tensor, " n"], int]:
    """Labels as numbers (n,) int64 in the order they first appear, −1 for none, and how many groups there are."""
    labels = [label.item() if hasattr(label, "item") else label for label in labels]
    if len(labels) != n:
        raise InputError(f"labels: expected one for each of {n} shapes, got {len(labels)}")
    numbers: dict = {}
    codes = [-1 if _is_none(label) else numbers.setdefault(label, len(numbers)) for label in labels]
    return torch.tensor(codes, dtype=torch.int64), len(numbers)


def as_stack(name: str, D) -> Float[Tensor, "n m m"]:
    """Operators (n, m, m) as a float64 tensor.

    Raises:
        InputError: another shape.
    """
    D = as_operators(name, D)
    if D.ndim != 3:
        raise InputError(f"{name}: expected operators (n, m, m), got {tuple(D.shape)}")
    return D


def _is_none(label) -> bool:
    return label is None or label == "" or label != label  # nan alone differs from itself
