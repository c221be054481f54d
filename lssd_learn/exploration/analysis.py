"""All that one kind of operator tells of groups of shapes: what `task=compare` shows."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import torch
from jaxtyping import Float, Int
from torch import Tensor

from lssd_learn.collections.groups import ChosenGroups
from lssd_learn.exploration.blocks import within_blocks
from lssd_learn.exploration.embed import Embedding, embed
from lssd_learn.exploration.evidence import evidence, evidence_stability
from lssd_learn.exploration.separation import (
    PermutationTest,
    few_labels_accuracy,
    held_out_confusion,
    nearest_accuracy,
    permutation_test,
    silhouette,
)
from lssd_learn.exploration.variability import cross_collection, global_variability, highlighted
from lssd_learn.latent import LatentSpace
from lssd_learn.operators import project


@dataclass(frozen=True)
class Analysis:
    """What one kind of operator tells of the groups.

    Attributes:
        kind: the name of the difference.
        alpha: (m, count) functions that tell the groups apart, best first.
        region: (m, m) all functions of the method "difference" by their shares, see `evidence`.
        varied: (m,) the function that varies most, whatever the groups.
        before, after: principal components of the operators D and of the features Dα, n shapes each. Where blocks have
            several groups, the D of features, alpha and region are those of `within_blocks`.
        few: the same of Dα with α from a few labels a group.
        suppressed: of the operators projected, D(I − ααᵀ) + ααᵀ: what varies otherwise.
        sizes: label → mean of tr(RᵀDR) / tr(RᵀR): how large the region is in a group; 1 is as in the collection's mean.
        taken: (g, g) how many shapes of each group (rows) are taken for which, see `held_out_confusion`.
        test: the permutation test.
        metrics: flat numbers, the kind not yet before their names.
    """

    kind: str
    alpha: Float[Tensor, "m count"]
    region: Float[Tensor, "m m"]
    varied: Float[Tensor, " m"]
    before: Embedding
    after: Embedding
    few: Embedding | None
    suppressed: Embedding
    sizes: dict[str, float]
    taken: Int[np.ndarray, "g g"]
    test: PermutationTest
    metrics: dict[str, float]


def analyse(
    kind: str,
    latent: LatentSpace,
    operators: Float[Tensor, "n m m"],
    groups: ChosenGroups,
    *,
    method: str = "difference",
    mean: bool = True,
    epsilon: float = 1e-2,
    count: int = 2,
    permutations: int = 999,
    few: int | None = None,
    seed: int = 0,
) -> Analysis:
    """Everything there is to say of the groups by one kind of operator.

    Args:
        kind: its name.
        latent: the space of the whole collection.
        operators: (n, m, m) of the whole collection.
        groups: positions in it, and blocks.
        method, mean, epsilon, count: of `cross_collection`, for alpha.
        permutations: of `permutation_test`.
        few: of `few_labels_accuracy`; None leaves it out, and so does a group that has no more shapes.
        seed: of what is random.
    """
    everyone: list[str | None] = [None] * len(latent)
    belonging: list[str | None] = [None] * len(latent)
    for place, (i, label) in enumerate(zip(groups.shapes, groups.of, strict=True)):
        everyone[i] = label
        belonging[i] = None if groups.blocks is None else groups.blocks[place]
    blocks, raw = groups.blocks, operators[groups.shapes]
    whole = None if blocks is None else belonging
    # Where a block has several groups, shapes are compared with others of their own block.
    compared = operators if blocks is None else within_blocks(operators, everyone, belonging)
    D = compared[groups.shapes]
    how = {"method": method, "epsilon": epsilon}

    def alpha_of(labels) -> Tensor:
        return cross_collection(D, labels, count, mean=mean, **how)

    alpha = alpha_of(groups.of)
    features = highlighted(D, alpha)
    # By "difference", whatever α is by: by "ratio" groups are told apart better, and the place is found worse.
    region = evidence(D, groups.of, mean=mean)
    stability = evidence_stability(latent, compared, everyone, mean=mean, blocks=whole)
    test = permutation_test(raw, groups.of, permutations, seed, blocks=blocks, **how)
    sizes = torch.einsum("aj,nab,bj->n", region, operators, region) / region.square().sum()
    smallest = min(len(groups.members(label)) for label in groups.labels)
    taken = held_out_confusion(D, groups.of, mean=mean, count=count, blocks=blocks, **how)
    order = [label for label in dict.fromkeys(groups.of) if label is not None]
    places = [order.index(label) for label in groups.labels]
    few = few if few is not None and few < smallest else None
    semi = {"seed": seed, "mean": mean, "count": count, "blocks": blocks, **how}
    projected = project(raw, torch.linalg.qr(alpha)[0])
    return Analysis(
        kind=kind,
        alpha=alpha,
        region=region,
        varied=global_variability(raw),
        before=embed(raw),
        after=embed(D, alpha=alpha),
        few=None
        if few is None
        else embed(D, alpha=cross_collection(D, _first(groups.of, few), count, mean=mean, **how)),
        suppressed=embed(projected),
        sizes={label: float(sizes[groups.members(label)].mean()) for label in groups.labels},
        taken=taken[np.ix_(places, places)],
        test=test,
        metrics={
            "silhouette/before": silhouette(raw, groups.of),
            "silhouette/after": silhouette(features, groups.of),
            "silhouette/suppressed": silhouette(projected, groups.of),
            "accuracy/before": nearest_accuracy(raw, groups.of, blocks),
            "accuracy/after": float(taken.trace() / taken.sum()),
            **({} if few is None else {"accuracy/few": few_labels_accuracy(D, groups.of, few, **semi)}),
            "statistic": test.statistic,
            "p_value": test.p_value,
            "p_value/smallest": test.smallest,
            "stability": float(stability.mean()),
            "stability/lowest": float(stability.min()),
        },
    )


def _first(labels: Sequence[str | None], few: int) -> list[str | None]:
    """The labels of the first `few` shapes of each group, None of the others."""
    seen: Counter = Counter()
    kept = []
    for label in labels:
        seen[label] += 1
        kept.append(label if seen[label] <= few else None)
    return kept
