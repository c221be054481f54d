"""The closed-form baselines of `task=baselines`: features of all kinds, each with the ridge regression best for it."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from torch import Tensor

from lssd_learn.division.split import Split
from lssd_learn.learning.references.gram import gram, ridge_of_gram
from lssd_learn.learning.references.parameters import Reference, operator_features, ridge_reference, score


@dataclass(frozen=True)
class BaseScore:
    """What the differences from one base shape reach: its position in the collection, and a reference a kind."""

    base: int
    by_kind: dict[str, Reference]


def wide_baseline(features: Float[np.ndarray, "n d"], targets: Float[np.ndarray, "n p"], split: Split) -> Reference:
    """Of features (n, d), d far above n: by their inner products, without a copy of them all."""
    return score(ridge_of_gram(gram(features, split.train), targets, split.train), targets, split)


def spectrum_baseline(evals: Float[np.ndarray, "n k"], targets: Float[np.ndarray, "n p"], split: Split) -> Reference:
    """Of Shape-DNA (n, k) without the constant's zero, or of its logarithms: whichever is better on validation."""
    evals = np.asarray(evals, dtype=np.float64)[:, 1:]
    logarithms = np.log(np.maximum(evals, np.finfo(float).tiny))  # of a shape that all but falls apart
    both = [ridge_reference(features, targets, split) for features in (evals, logarithms)]
    return min(both, key=lambda baseline: baseline.validation)


def base_scores(
    differences: Iterable[tuple[int, Sequence[Tensor]]],
    targets: Float[np.ndarray, "n p"],
    split: Split,
    kinds: Mapping[str, Sequence[int]],
) -> list[BaseScore]:
    """What every base shape reaches.

    Args:
        differences: of each base its position and some differences (n, m, m) of all shapes from it, see `BaseShapes`.
        targets: (n, p) float64.
        split: train fits, validation chooses a strength for each kind, test is scored.
        kinds: what to score → the positions of the differences that it is regressed on.
    """
    scores = []
    for base, channels in differences:
        grams = [gram(operator_features(channel[:, None]), split.train) for channel in channels]
        products = {kind: np.asarray(sum(grams[c] for c in some)) for kind, some in kinds.items()}
        ridges = {kind: ridge_of_gram(inner, targets, split.train) for kind, inner in products.items()}
        scores.append(BaseScore(base, {kind: score(ridge, targets, split) for kind, ridge in ridges.items()}))
    return scores
