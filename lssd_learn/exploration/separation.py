"""How well groups of shapes are told apart, and whether that could be chance."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import torch
from sklearn.metrics import silhouette_score
from torch import Tensor

from lssd_learn.errors import InputError, check_whole
from lssd_learn.exploration.pairs import as_stack, coded_energies, group_codes, pair_energies
from lssd_learn.exploration.variability import SMALLEST, contrast, highlighted
from lssd_learn.operators.matrices import as_float64

# So many permutations at a time, for a bounded memory.
CHUNK = 128


@dataclass(frozen=True)
class PermutationTest:
    """`statistic`, `permuted` (N,) the same under permuted labels, and `p_value`."""

    statistic: float
    permuted: Tensor
    p_value: float


def silhouette(points, labels: Sequence) -> float:
    """Mean of (b − a) / max(a, b) in [−1, 1]: a the mean distance to one's own group, b to the nearest other.

    Args:
        points: (n, …) embedded shapes or features, compared by Euclidean distance.
        labels: n; None, "" or nan leaves a shape out. One that is alone in its group scores 0.

    Raises:
        InputError: a wrong number of labels, fewer than two groups.

    Reference:
        Rousseeuw, "Silhouettes", Journal of Computational and Applied Mathematics 20 (1987).
    """
    distances, codes, count = _distances(points, labels)
    alone = count == len(codes)  # every one of them: scikit-learn refuses that
    return 0.0 if alone else float(silhouette_score(distances.numpy(), codes.numpy(), metric="precomputed"))


def nearest_accuracy(points, labels: Sequence) -> float:
    """The part of the shapes whose nearest other shape has their label. Arguments as `silhouette`.

    Features that were made with the labels, such as `highlighted`, flatter themselves: see `held_out_accuracy`.
    """
    distances, codes, _ = _distances(points, labels)
    return float((codes[distances.fill_diagonal_(torch.inf).argmin(1)] == codes).double().mean())


def held_out_accuracy(
    D, labels: Sequence, method: str = "difference", mean: bool = True, epsilon: float = 1e-2, count: int = 1
) -> float:
    """The same for β_i = D_iα, with α from `cross_collection` without the label of the shape that is asked about.

    Args:
        D: (n, m, m) operators.
        labels: n of them; None, "" or nan leaves a shape out.
        method, mean, epsilon, count: of `cross_collection`.

    Raises:
        InputError: as `cross_collection`, for any of the shapes left out.
    """
    D = as_stack("D", D)
    codes, _ = group_codes(labels, len(D))
    known = (codes >= 0).nonzero().flatten()
    D, codes = D[known], codes[known]
    right = 0
    for i in range(len(D)):
        others = [None if j == i else int(code) for j, code in enumerate(codes)]
        features = highlighted(D, contrast(pair_energies(D, others, mean), method, epsilon)[:, :count]).flatten(1)
        distances = (features - features[i]).norm(dim=1)
        distances[i] = torch.inf
        right += int(codes[int(distances.argmin())] == codes[i])
    return right / len(D)


def few_labels_accuracy(
    D,
    labels: Sequence,
    few: int,
    draws: int = 20,
    seed: int = 0,
    method: str = "difference",
    mean: bool = True,
    epsilon: float = 1e-2,
    count: int = 1,
) -> float:
    """Semi-supervised: the part of the other shapes that are told right where `few` of each group have their labels.

    α comes from the labelled few, and β_i = D_iα of all shapes; a shape gets the label of the nearest of the few.

    Args:
        D: (n, m, m) operators.
        labels: n of them; None, "" or nan leaves a shape out.
        few: shapes of each group that keep their label, drawn at random.
        draws: how often; the mean of all is given.
        seed: of the draws.
        method, mean, epsilon, count: of `cross_collection`.

    Raises:
        InputError: as `cross_collection`; arguments out of range, a group with no shape left to ask about.

    Source: "Clustering with Visual Evidence" in the paper.
    """
    D = as_stack("D", D)
    check_whole("few", few, 1)
    check_whole("draws", draws, 1)
    check_whole("seed", seed, 0)
    codes, groups_found = group_codes(labels, len(D))
    known = codes >= 0
    D, codes = D[known], codes[known]
    members = [(codes == g).nonzero().flatten().numpy() for g in range(groups_found)]
    if groups_found and (smallest := min(map(len, members))) <= few:
        raise InputError(f"few={few}: expected less than {smallest}, the shapes of the smallest group")
    rng, rates = np.random.default_rng(seed), []
    for _ in range(draws):
        kept = torch.from_numpy(np.concatenate([rng.permutation(some)[:few] for some in members]))
        asked = torch.ones(len(D), dtype=torch.bool)
        asked[kept] = False
        alpha = contrast(pair_energies(D[kept], codes[kept], mean), method, epsilon)[:, :count]
        features = highlighted(D, alpha).flatten(1)
        nearest = torch.cdist(features[asked], features[kept]).argmin(1).cpu()
        rates.append(float((codes[kept][nearest] == codes[asked]).double().mean()))
    return float(np.mean(rates))


def permutation_test(
    D, labels: Sequence, permutations: int = 999, seed: int = 0, method: str = "difference", epsilon: float = 1e-2
) -> PermutationTest:
    """Are the groups farther apart than groups of the same sizes drawn at random?

    The statistic is the mean of ‖(D_i − D_j)α‖² over pairs of two groups, over that of pairs of one (means as in
    `pair_energies`), for the best function α of the grouping. It is found again in every permutation: as it has seen
    the labels, the statistic is large for any grouping. p = (1 + how many permutations reach it) / (1 + permutations).

    Args:
        D: (n, m, m) operators.
        labels: n, of two groups or more; None, "" or nan leaves a shape out.
        permutations: how many.
        seed: of the permutations.
        method, epsilon: of `cross_collection`.

    Raises:
        InputError: arguments out of range, fewer than two groups, no two shapes in one group.
    """
    D = as_stack("D", D)
    check_whole("permutations", permutations, 1)
    check_whole("seed", seed, 0)
    codes, count = group_codes(labels, len(D))
    known = codes >= 0
    D, codes = D[known], codes[known]
    if not 2 <= count < len(D):
        raise InputError(
            f"labels: expected two groups or more, and two shapes in one of them, got {count} of {len(D)} shapes"
        )
    many = np.random.default_rng(seed).permuted(np.tile(codes.numpy(), (permutations, 1)), axis=1)
    groupings = torch.cat([codes[None], torch.from_numpy(many)])
    found = torch.cat([_statistic(D, part, count, method, epsilon) for part in groupings.split(CHUNK)])
    # A permutation may be the grouping itself, up to rounding.
    reached = int((found[1:] >= found[0] * (1 - 1e-9)).sum())
    return PermutationTest(float(found[0]), found[1:], (1 + reached) / (1 + permutations))


def _statistic(D: Tensor, codes: Tensor, count: int, method: str, epsilon: float) -> Tensor:
    """(N,) for groupings `codes` (N, n)."""
    energies = coded_energies(D, codes, count, mean=True)
    alpha = contrast(energies, method, epsilon)[..., :1]
    across, within = ((alpha.mT @ E @ alpha).flatten() for E in (energies.across, energies.within))
    return across / within.clamp(min=SMALLEST)


def _distances(points, labels: Sequence) -> tuple[Tensor, Tensor, int]:
    points = as_float64(points).flatten(1).cpu()
    codes, count = group_codes(labels, len(points))
    if count < 2:
        raise InputError(f"labels: expected two groups or more, got {count}")
    points, codes = points[codes >= 0], codes[codes >= 0]
    return torch.cdist(points, points, compute_mode="donot_use_mm_for_euclid_dist"), codes, count
