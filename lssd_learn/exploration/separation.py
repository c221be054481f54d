"""How well groups of shapes are told apart, and whether that could be chance."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import cast

import numpy as np
import torch
from jaxtyping import Float, Int
from sklearn.metrics import silhouette_score
from torch import Tensor

from lssd_learn.errors import InputError, check_whole
from lssd_learn.exploration.blocks import Design, block_codes, paired_energies
from lssd_learn.exploration.pairs import as_stack, coded_energies, group_codes, pair_energies
from lssd_learn.exploration.variability import SMALLEST, contrast, highlighted
from lssd_learn.operators.matrices import as_float64

# So many permutations at a time, for a bounded memory.
CHUNK = 128


@dataclass(frozen=True)
class PermutationTest:
    """What a permutation test found.

    Attributes:
        statistic: of the groups.
        permuted: (N,) the same under permuted labels.
        p_value: the part of all 1 + N that are as large.
        smallest: the least p there could be.
        exact: whether the permuted are all there are, each once.
    """

    statistic: float
    permuted: Float[Tensor, " N"]
    p_value: float
    smallest: float
    exact: bool


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


def nearest_accuracy(points, labels: Sequence, blocks: Sequence | None = None) -> float:
    """The part of the shapes whose nearest other shape has their label. Arguments as `silhouette`.

    Features that were made with the labels, such as `highlighted`, flatter themselves: see `held_out_accuracy`.

    Args:
        blocks: n labels of what belongs together, or None: the nearest shape is then one of another block.
    """
    distances, codes, _ = _distances(points, labels)
    belonging = _belonging(labels, blocks)[:, None] == _belonging(labels, blocks)
    return float((codes[distances.masked_fill_(belonging, torch.inf).argmin(1)] == codes).double().mean())


def held_out_accuracy(
    D,
    labels: Sequence,
    method: str = "difference",
    mean: bool = True,
    epsilon: float = 1e-2,
    count: int = 1,
    blocks: Sequence | None = None,
) -> float:
    """The same for β_i = D_iα, with α from `cross_collection` without the label of the shape that is asked about.

    With blocks it is found without the labels of the whole block, and the nearest shape is one of another block.

    Args:
        D: (n, m, m) operators.
        labels: n of them; None, "" or nan leaves a shape out.
        method, mean, epsilon, count: of `cross_collection`.
        blocks: n labels of what belongs together, None where nothing does; a shape without one stands alone.

    Raises:
        InputError: as `cross_collection`, for any of the shapes or blocks left out.
    """
    counts = held_out_confusion(D, labels, method, mean, epsilon, count, blocks)
    return float(counts.trace() / counts.sum())


def held_out_confusion(
    D,
    labels: Sequence,
    method: str = "difference",
    mean: bool = True,
    epsilon: float = 1e-2,
    count: int = 1,
    blocks: Sequence | None = None,
) -> Int[np.ndarray, "g g"]:
    """How many shapes of each group (rows) are taken for which: (g, g), groups as they first appear in the labels.

    All else as `held_out_accuracy`, the part of the shapes on the diagonal.
    """
    D = as_stack("D", D)
    codes, groups = group_codes(labels, len(D))
    belonging = _belonging(labels, blocks)
    known = (codes >= 0).nonzero().flatten()
    D, codes = D[known], codes[known]
    counts = np.zeros((groups, groups), dtype=np.int64)
    for block in belonging.unique():
        out = belonging == block
        others = [None if gone else int(code) for gone, code in zip(out, codes, strict=True)]
        features = highlighted(D, contrast(pair_energies(D, others, mean), method, epsilon)[:, :count]).flatten(1)
        for i in out.nonzero().flatten().tolist():
            distances = (features - features[i]).norm(dim=1)
            distances[out] = torch.inf
            counts[int(codes[i]), int(codes[int(distances.argmin())])] += 1
    return counts


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
    blocks: Sequence | None = None,
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
        blocks: n labels of what belongs together, or None. Half of the blocks of each kind, as to which groups they
            have, are then drawn first: the few are of these, or all they have if that is less, and the shapes of the
            others are asked about.

    Raises:
        InputError: as `cross_collection`; arguments out of range, a group with no shape left to ask about.

    Source: "Clustering with Visual Evidence" in the paper.
    """
    D = as_stack("D", D)
    check_whole("few", few, 1)
    check_whole("draws", draws, 1)
    check_whole("seed", seed, 0)
    codes, groups_found = group_codes(labels, len(D))
    belonging = None if blocks is None else _belonging(labels, blocks).numpy()
    known = codes >= 0
    D, codes = D[known], codes[known]
    members = [(codes == g).nonzero().flatten().numpy() for g in range(groups_found)]
    if groups_found and (smallest := min(map(len, members))) <= few:
        raise InputError(f"few={few}: expected less than {smallest}, the shapes of the smallest group")
    rng, rates = np.random.default_rng(seed), []
    for _ in range(draws):
        pool = np.arange(len(D)) if belonging is None else _half(codes.numpy(), belonging, rng)
        kept = np.concatenate([rng.permutation(some[np.isin(some, pool)])[:few] for some in members])
        asked = torch.ones(len(D), dtype=torch.bool)
        asked[kept if belonging is None else pool] = False
        if not asked.any():
            raise InputError("blocks: expected two or more of each kind, so that some are left to ask about")
        kept = torch.from_numpy(kept)
        alpha = contrast(pair_energies(D[kept], codes[kept].tolist(), mean), method, epsilon)[:, :count]
        features = highlighted(D, alpha).flatten(1)
        nearest = torch.cdist(features[asked], features[kept]).argmin(1).cpu()
        rates.append(float((codes[kept][nearest] == codes[asked]).double().mean()))
    return float(np.mean(rates))


def permutation_test(
    D,
    labels: Sequence,
    permutations: int = 999,
    seed: int = 0,
    method: str = "difference",
    epsilon: float = 1e-2,
    blocks: Sequence | None = None,
) -> PermutationTest:
    """Are the groups farther apart than groups of the same sizes drawn at random?

    The statistic is the mean of ‖(D_i − D_j)α‖² over pairs of two groups, over that of pairs of one (means as in
    `pair_energies`), for the best function α of the grouping. It is found again in every permutation: as it has seen
    the labels, the statistic is large for any grouping. p = (1 + how many permutations reach it) / (1 + permutations).

    With blocks labels are permuted as `Design` says. Where two blocks or more have several groups, these are tested by
    `paired_energies`, and the other blocks by the statistic above. Where there are both, the statistic is −Σ log p of
    the two (Fisher's), each p the part of the permutations that reach it.

    Args:
        D: (n, m, m) operators.
        labels: n, of two groups or more; None, "" or nan leaves a shape out.
        permutations: how many; where there are no more than that, each is taken once.
        seed: of the permutations.
        method, epsilon: of `cross_collection`.
        blocks: n labels of what belongs together, None where nothing does; a shape without one stands alone.

    Raises:
        InputError: arguments out of range, fewer than two groups, no two shapes in one group, blocks that leave nothing
            to permute.
    """
    D = as_stack("D", D)
    check_whole("permutations", permutations, 1)
    check_whole("seed", seed, 0)
    labels = list(labels)
    codes, count = group_codes(labels, len(D))
    known = codes >= 0
    D, codes = D[known], codes[known]
    if not 2 <= count < len(D):
        raise InputError(
            f"labels: expected two groups or more, and two shapes in one of them, got {count} of {len(D)} shapes"
        )
    design = Design.of_labels(labels, blocks)
    groupings, exact = design.groupings(permutations, seed)
    found = _statistics(D, design, groupings, method, epsilon)
    smallest = float(_reached(found, found.max()).double().mean()) if exact else 1 / len(found)
    p_value = float(_reached(found, found[0]).double().mean())
    return PermutationTest(float(found[0]), found[1:], p_value, smallest, exact)


def _statistics(D: Tensor, design: Design, groupings: np.ndarray, method: str, epsilon: float) -> Tensor:
    """(N,) of groupings (N, n)."""

    def of(some: np.ndarray) -> Tensor:
        present, codes = np.unique(groupings[:, some], return_inverse=True)
        parts = torch.from_numpy(codes.reshape(len(groupings), -1)).split(CHUNK)
        return torch.cat([_statistic(D[some], part, len(present), method, epsilon) for part in parts])

    everyone = np.arange(design.varied.size)
    if not design.contrasts():
        return of(everyone)
    paired = paired_energies(D, design, groupings)
    if all(design.varied[units[0, 0]] for units in design.exchanges):
        return paired
    found = (paired, of(np.flatnonzero(~design.varied)))
    shares = (torch.stack([_reached(one, value).double().mean() for value in one]) for one in found)
    return cast(Tensor, sum(-share.log() for share in shares))


def _reached(found: Tensor, value: Tensor) -> Tensor:
    """(N,) bool which statistics are as large as one, which a permutation may be up to rounding."""
    return found >= value - 1e-9 * value.abs()


def _statistic(D: Tensor, codes: Tensor, count: int, method: str, epsilon: float) -> Tensor:
    """(N,) for groupings `codes` (N, n)."""
    energies = coded_energies(D, codes, count, mean=True)
    alpha = contrast(energies, method, epsilon)[..., :1]
    across, within = ((alpha.mT @ E @ alpha).flatten() for E in (energies.across, energies.within))
    return across / within.clamp(min=SMALLEST)


def _belonging(labels: Sequence, blocks: Sequence | None) -> Tensor:
    """(l,) numbers of the blocks of the shapes that have a label, each its own without blocks."""
    codes, _ = group_codes(labels, len(labels))
    found = np.arange(len(codes)) if blocks is None else block_codes(blocks, len(codes))
    return torch.from_numpy(found)[codes >= 0]


def _half(codes: np.ndarray, blocks: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """The shapes of half of the blocks, rounded up, of each kind: those that have the same groups."""
    kinds: dict[frozenset, list[int]] = {}
    for block in np.unique(blocks).tolist():
        kinds.setdefault(frozenset(codes[blocks == block].tolist()), []).append(block)
    chosen = [rng.permutation(some)[: (len(some) + 1) // 2] for some in kinds.values()]
    return np.flatnonzero(np.isin(blocks, np.concatenate(chosen)))


def _distances(points, labels: Sequence) -> tuple[Tensor, Tensor, int]:
    points = as_float64(points).flatten(1).cpu()
    codes, count = group_codes(labels, len(points))
    if count < 2:
        raise InputError(f"labels: expected two groups or more, got {count}")
    points, codes = points[codes >= 0], codes[codes >= 0]
    return torch.cdist(points, points, compute_mode="donot_use_mm_for_euclid_dist"), codes, count
