"""What `compare.py` compares and what it finds: groups, and one analysis for each kind of operator."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import torch
from torch import Tensor

from lssd_learn.collections.base import Collection
from lssd_learn.errors import InputError
from lssd_learn.exploration import (
    Embedding,
    cross_collection,
    embed,
    few_labels_accuracy,
    global_variability,
    held_out_accuracy,
    highlighted,
    nearest_accuracy,
    permutation_test,
    silhouette,
)
from lssd_learn.exploration.evidence import evidence, evidence_stability
from lssd_learn.latent import LatentSpace
from lssd_learn.operators import project
from lssd_learn.tasks.groups import choose_group


@dataclass(frozen=True)
class Groups:
    """Some groups of shapes.

    Attributes:
        name: what the shapes are grouped by.
        labels: of the groups that are compared, as texts, in ascending order or as they were asked for.
        shapes: (n,) positions in the collection of the shapes that are looked at.
        of: n labels; None is a shape whose group is not known, which is looked at and otherwise plays no part.
    """

    name: str
    labels: list[str]
    shapes: np.ndarray
    of: list[str | None]

    def members(self, label: str) -> np.ndarray:
        """The positions in the collection of the shapes of one group."""
        return self.shapes[[other == label for other in self.of]]


@dataclass(frozen=True)
class Analysis:
    """What one kind of operator tells of the groups.

    Attributes:
        kind: area or conformal.
        alpha: (m, count) functions that tell the groups apart, best first.
        region: (m, m) all functions of the method "difference" by their shares, see `evidence`.
        varied: (m,) the function that varies most, whatever the groups.
        before, after: principal components of the operators D and of the features Dα, n shapes each.
        few: the same of Dα with α from a few labels a group.
        suppressed: of the operators projected, D(I − ααᵀ) + ααᵀ: what varies otherwise.
        sizes: label → mean of tr(RᵀDR) / tr(RᵀR): how large the region is in a group; 1 is as in the collection's mean.
        metrics: flat numbers, the kind not yet before their names.
    """

    kind: str
    alpha: Tensor
    region: Tensor
    varied: Tensor
    before: Embedding
    after: Embedding
    few: Embedding | None
    suppressed: Embedding
    sizes: dict[str, float]
    metrics: dict[str, float]


def choose_groups(
    collection: Collection, group: str | None = None, labels: Sequence = (), unlabelled: str | None = None
) -> Groups:
    """The groups to compare.

    Args:
        collection: whose groups.
        group: the name of one of its groupings; None is the only one there is.
        labels: two or more of its labels, and then shapes of others are left out; empty is all.
        unlabelled: the label of shapes whose group is not known. (A label that is empty says so too.)

    Raises:
        InputError: no such grouping or label, fewer than two groups, a group of one shape.
    """
    name = choose_group(collection, group, "task.group")
    unknown = ("", "None", "nan") if unlabelled is None else ("", "None", "nan", str(unlabelled))
    found = [None if str(label) in unknown else str(label) for label in collection.groups[name]]
    known = sorted({label for label in found if label is not None})
    chosen = list(dict.fromkeys(map(str, labels))) or known
    asked = f"task.group={name}" if not len(labels) else f"task.labels=[{','.join(map(str, labels))}]"
    if missing := [label for label in chosen if label not in known]:
        raise InputError(f"{asked}: {name} has no label {missing[0]!r}; it has {', '.join(known)}")
    if len(chosen) < 2:
        raise InputError(f"{asked}: expected two labels or more to compare, got {', '.join(chosen) or 'none'}")
    if alone := [label for label in chosen if found.count(label) < 2]:
        raise InputError(f"{asked}: expected two shapes or more of each label, got one of {alone[0]!r}")
    shapes = np.array([i for i, label in enumerate(found) if label is None or label in chosen])
    return Groups(name, chosen, shapes, [found[i] for i in shapes])


def analyse(
    kind: str,
    latent: LatentSpace,
    operators: Tensor,
    groups: Groups,
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
        groups: positions in it.
        method, mean, epsilon, count: of `cross_collection`, for alpha.
        permutations: of `permutation_test`.
        few: of `few_labels_accuracy`; None leaves it out, and so does a group that has no more shapes.
        seed: of what is random.
    """
    everyone = [None] * len(latent)
    for i, label in zip(groups.shapes, groups.of, strict=True):
        everyone[i] = label
    D = operators[groups.shapes]
    how = {"method": method, "epsilon": epsilon}

    def alpha_of(labels) -> Tensor:
        return cross_collection(D, labels, count, mean=mean, **how)

    alpha = alpha_of(groups.of)
    features = highlighted(D, alpha)
    # By "difference", whatever α is by: by "ratio" groups are told apart better, and the place is found worse.
    region = evidence(D, groups.of, mean=mean)
    stability = evidence_stability(latent, operators, everyone, mean=mean)
    test = permutation_test(D, groups.of, permutations, seed, **how)
    sizes = torch.einsum("aj,nab,bj->n", region, operators, region) / region.square().sum()
    smallest = min(len(groups.members(label)) for label in groups.labels)
    few = few if few is not None and few < smallest else None
    semi = {"seed": seed, "mean": mean, "count": count, **how}
    projected = project(D, torch.linalg.qr(alpha)[0])
    return Analysis(
        kind=kind,
        alpha=alpha,
        region=region,
        varied=global_variability(D),
        before=embed(D),
        after=embed(D, alpha=alpha),
        few=None
        if few is None
        else embed(D, alpha=cross_collection(D, _first(groups.of, few), count, mean=mean, **how)),
        suppressed=embed(projected),
        sizes={label: float(sizes[groups.members(label)].mean()) for label in groups.labels},
        metrics={
            "silhouette/before": silhouette(D, groups.of),
            "silhouette/after": silhouette(features, groups.of),
            "silhouette/suppressed": silhouette(projected, groups.of),
            "accuracy/before": nearest_accuracy(D, groups.of),
            "accuracy/after": held_out_accuracy(D, groups.of, mean=mean, count=count, **how),
            **({} if few is None else {"accuracy/few": few_labels_accuracy(D, groups.of, few, **semi)}),
            "statistic": test.statistic,
            "p_value": test.p_value,
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
