"""The closed-form baselines of `task=baselines`: features of all kinds, each with the ridge regression best for it."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import ArrayLike
from torch import Tensor

from lssd_learn.learning.references.gram import gram, ridge_of_gram
from lssd_learn.learning.references.parameters import Reference, operator_features
from lssd_learn.learning.references.ridge import ALPHAS, Ridge
from lssd_learn.learning.split import Split
from lssd_learn.nets.kernel import log_vectors
from lssd_learn.nets.kernel_machine import NULL

BASE_KINDS = ("area", "operators")  # the area differences alone, and with the conformal ones


@dataclass(frozen=True)
class Baseline(Reference):
    """A reference with what it was chosen by: the mean squared error on validation."""

    validation: float = np.nan


@dataclass(frozen=True)
class BaseScore:
    """What the differences from one base shape reach: its position in the collection, and a baseline a kind."""

    base: int
    by_kind: dict[str, Baseline]


def score(ridge: Ridge, targets: np.ndarray, split: Split, alphas: Sequence[float] = ALPHAS) -> Baseline:
    """A ridge regression of the strength that is best on validation, on the test split; the law of `ridge_reference`.

    Args:
        ridge: fitted to split.train.
        targets: (n, p) float64.
        split: validation chooses a, test is scored.
        alphas: the a to choose from.
    """

    def error(positions: np.ndarray, alpha: float) -> np.ndarray:
        return ridge.predict(positions, alpha) - targets[positions]

    found = [float(np.mean(error(split.validation, alpha) ** 2)) for alpha in alphas]
    best = int(np.argmin(found))
    test = error(split.test, alphas[best])
    return Baseline(float(np.mean(test**2)), float(np.mean(np.abs(test))), float(alphas[best]), found[best])


def feature_baseline(features: ArrayLike, targets: np.ndarray, split: Split) -> Baseline:
    """Of features (n, d); those that are all the same predict the mean of the training targets."""
    return score(Ridge.fit(features, targets, split.train), targets, split)


def wide_baseline(features: np.ndarray, targets: np.ndarray, split: Split) -> Baseline:
    """Of features (n, d), d far above n: by their inner products, without a copy of them all."""
    return score(ridge_of_gram(gram(features, split.train), targets, split.train), targets, split)


def spectrum_baseline(evals: np.ndarray, targets: np.ndarray, split: Split) -> Baseline:
    """Of Shape-DNA (n, k) without the constant's zero, or of its logarithms: whichever is better on validation."""
    evals = np.asarray(evals, dtype=np.float64)[:, 1:]
    logarithms = np.log(np.maximum(evals, np.finfo(float).tiny))  # of a shape that all but falls apart
    both = [feature_baseline(features, targets, split) for features in (evals, logarithms)]
    return min(both, key=lambda baseline: baseline.validation)


def log_features(operators: Tensor, train: np.ndarray) -> np.ndarray:
    """(n, channels, m, m) symmetric operators → (n, d) logarithms, with the inner products of these.

    Functions that are null on all training shapes are left out of a channel, the constant of conformal operators.
    """
    size = operators[train].abs().amax((0, 2))
    live = size > NULL * size.amax(1, keepdim=True)
    channels = [log_vectors(operators[:, c][:, some][:, :, some]) for c, some in enumerate(live)]
    return torch.cat(channels, dim=1).numpy()


def base_scores(
    differences: Iterable[tuple[int, tuple[Tensor, Tensor]]], targets: np.ndarray, split: Split
) -> list[BaseScore]:
    """What every base shape reaches.

    Args:
        differences: of each base its position and area and symmetric conformal differences (n, m, m) of all shapes
            from it, see `BaseShapes`.
        targets: (n, p) float64.
        split: as in `score`.
    """
    scores = []
    for base, pair in differences:
        area, conformal = (gram(operator_features(channel[:, None]), split.train) for channel in pair)
        products = dict(zip(BASE_KINDS, (area, area + conformal), strict=True))
        ridges = {kind: ridge_of_gram(inner, targets, split.train) for kind, inner in products.items()}
        scores.append(BaseScore(base, {kind: score(ridge, targets, split) for kind, ridge in ridges.items()}))
    return scores
