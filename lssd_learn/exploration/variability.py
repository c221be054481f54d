"""Which functions on the latent shape tell shapes apart: all of them, or two groups of them.

A function counts for how much nearer shapes come to each other when it is suppressed (`operators.delta_energy`), summed
over pairs. The best ones are eigenvectors of the energies in `pairs.py`. Source: "Shape Collection Comparison" in the
paper.

Signs: the coefficient of largest magnitude is positive. To be looked at as `latent.to_shape(alpha, i)`, or its square.
"""

import logging
from collections.abc import Sequence

import torch
from jaxtyping import Float
from torch import Tensor

from lssd_learn.errors import InputError, check_positive, check_whole
from lssd_learn.exploration.pairs import PairEnergies, as_stack, group_codes, pair_energies, sums_about
from lssd_learn.operators.matrices import as_float64, as_operators

log = logging.getLogger(__name__)

METHODS = ("difference", "ratio")

# Shapes that do not vary at all divide by this.
SMALLEST = 1e-150


def global_variability(D, count: int | None = None) -> Float[Tensor, " m *count"]:
    """The function that varies most in a collection: maximises Σ_pairs δ(S_i, S_j, α), αᵀα = 1 (the paper's Eq. intra).

    Args:
        D: (n, m, m) operators; non-symmetric ones too.
        count: how many functions, best first; None is the best alone.

    Returns:
        (m,), or (m, count) orthonormal, float64.

    Raises:
        InputError: fewer than two shapes, more functions than there are.
    """
    D = as_stack("D", D)
    if len(D) < 2:
        raise InputError(f"D: expected two operators or more, got {len(D)}")
    return _best(_all_pairs(D), count)


def within_group(D, labels: Sequence, count: int | None = None) -> Tensor:
    """The function that varies most among shapes of the same group, pairs of all groups together: the nuisance.

    Args:
        D, labels: see `pair_energies`.
        count: as `global_variability`.

    Raises:
        InputError: as `pair_energies`, and no two shapes in one group.
    """
    energies = pair_energies(D, labels)
    _check_pairs(energies)
    return _best(energies.within, count)


def cross_collection(
    D,
    labels: Sequence,
    count: int | None = None,
    method: str = "difference",
    mean: bool = True,
    epsilon: float = 1e-2,
) -> Float[Tensor, " m *count"]:
    """What tells groups apart: moves shapes of different groups nearer, those of one group as little as possible.

    "difference" is the paper's Eq. inter: the largest eigenvectors of across − within. Summed over pairs as there, that
    is (S_A − S_B)ᵀ(S_A − S_B) exactly for two groups of equal size, the difference of the means: what varies within
    groups is not penalised, and by chance makes a difference too. For unequal sizes, what varies in the smaller group
    counts in favour. With means over pairs, the default, it is an unbiased estimate of the difference of the means for
    any sizes: what varies within groups neither gains nor loses on average. "ratio" penalises it:
    across α = μ (within + ε (tr within / m) I) α.

    Args:
        D: (n, m, m) operators; non-symmetric ones too.
        labels: n, of two groups or more; None, "" or nan where unknown: functions come from the labelled few and
            may be seen on all (`highlighted`).
        count: how many functions, best first; None is the best alone.
        method: "difference" or "ratio".
        mean: over pairs, see `pair_energies`; False sums, as the paper does.
        epsilon: of "ratio", keeps functions out that hardly vary at all.

    Returns:
        (m,), or (m, count), of unit length, float64; orthonormal of "difference" only.

    Raises:
        InputError: as `pair_energies`; an unknown method; "ratio" where no two shapes are in one group.
    """
    functions = contrast(pair_energies(D, labels, mean), method, epsilon)
    codes, groups_found = group_codes(labels, len(D))
    sizes = torch.bincount(codes[codes >= 0])
    if method == "difference" and not mean and groups_found == 2 and sizes[0] == sizes[1]:
        log.warning(
            "two groups of %d: summed over pairs, what varies within them is not penalised (mean=True subtracts what "
            "it adds by chance, method='ratio' penalises it)",
            sizes[0],
        )
    return _first(functions, count)


def contrast(energies: PairEnergies, method: str, epsilon: float = 1e-2) -> Float[Tensor, "*N m m"]:
    """All functions (…, m, m) of `cross_collection`, a column each, best first; energies of many groupings at once."""
    check_positive("epsilon", epsilon)
    if method not in METHODS:
        raise InputError(f"method={method!r}: expected one of {', '.join(METHODS)}")
    if method == "ratio":
        _check_pairs(energies)
    within, across = energies.within, energies.across
    if method == "difference":
        return _signed(torch.linalg.eigh(across - within)[1].flip(-1))
    size = within.diagonal(dim1=-2, dim2=-1).mean(-1)[..., None, None].clamp(min=SMALLEST)
    root = torch.linalg.cholesky(within + epsilon * size * torch.eye(within.shape[-1]).to(within))
    left = torch.linalg.solve_triangular(root, across, upper=False)
    whitened = torch.linalg.solve_triangular(root, left.mT, upper=False)
    vectors = torch.linalg.eigh((whitened + whitened.mT) / 2)[1].flip(-1)
    functions = torch.linalg.solve_triangular(root.mT, vectors, upper=True)
    return _signed(functions / functions.norm(dim=-2, keepdim=True))


def highlighted(D, alpha) -> Tensor:
    """β_i = D_i α (…, m), a feature vector a shape; or (…, m, p) of several functions (m, p).

    Functions of `cross_collection` make groups visible in the principal components of these ("Clustering with Visual
    Evidence" in the paper). They have seen the labels: to score a separation see `held_out_accuracy`.

    Raises:
        InputError: shapes that do not fit.
    """
    D = as_operators("D", D)
    alpha = as_float64(alpha).to(D)
    if alpha.ndim not in (1, 2) or len(alpha) != D.shape[-1]:
        m = D.shape[-1]
        raise InputError(f"alpha: expected a function ({m},) or several ({m}, p), got {tuple(alpha.shape)}")
    return D @ alpha


def _all_pairs(D: Tensor) -> Tensor:
    return len(D) * sums_about(D.mean(0), D)[1]


def _best(energy: Tensor, count: int | None) -> Tensor:
    return _first(_signed(torch.linalg.eigh(energy)[1].flip(-1)), count)


def _first(functions: Tensor, count: int | None) -> Tensor:
    if count is None:
        return functions[:, 0]
    check_whole("count", count, 1, functions.shape[1])
    return functions[:, :count]


def _check_pairs(energies: PairEnergies) -> None:
    if not energies.within_pairs:
        raise InputError("labels: expected two shapes or more in one of the groups")


def _signed(functions: Tensor) -> Tensor:
    extreme = functions.gather(-2, functions.abs().argmax(-2, keepdim=True))
    return functions * torch.where(extreme < 0, -1.0, 1.0).to(functions)
