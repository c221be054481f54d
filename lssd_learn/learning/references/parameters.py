"""What a net has to beat: the mean of the targets, and ridge regression, both in closed form on the same split."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
import torch
from jaxtyping import Float
from numpy.typing import ArrayLike

from lssd_learn.division.split import Split
from lssd_learn.errors import InputError
from lssd_learn.learning.references.ridge import ALPHAS, Ridge
from lssd_learn.operators.vectors import entries

TOGETHER = 4096  # operators that are looked at at once


@dataclass(frozen=True)
class Reference:
    """Mean squared and mean absolute error on the test split, over all entries.

    Attributes:
        mse, l1: on the test split.
        alpha: chosen on validation, where there was a choice.
        validation: the mean squared error there.
        errors: (t, p) on the test split, prediction less truth.
    """

    mse: float
    l1: float
    alpha: float | None
    validation: float
    errors: Float[np.ndarray, "t p"] = field(repr=False, compare=False)


def mean_reference(targets: ArrayLike, split: Split) -> Reference:
    """Predict the mean of the training targets for every shape; targets are (n, p)."""
    targets = _targets(targets)
    return _scored(lambda some: targets[split.train].mean(0), None, targets, split)


def ridge_reference(
    features: ArrayLike, targets: ArrayLike, split: Split, alphas: Sequence[float] = ALPHAS
) -> Reference:
    """Ridge regression (see `Ridge`) of the strength that is best on the validation split, every target in units of its
    deviation in training.

    Args:
        features: (n, d), such as `operator_features` gives. Scaling them all changes nothing.
        targets: (n, p).
        split: train fits, validation chooses a, test is scored.
        alphas: the a to choose from.
    """
    targets = _targets(targets)
    return score(Ridge.fit(features, targets, split.train), targets, split, alphas)


def score(ridge: Ridge, targets: Float[np.ndarray, "n p"], split: Split, alphas: Sequence[float] = ALPHAS) -> Reference:
    """Of the strength that is best on validation; the ridge regression is fitted to split.train, targets are (n, p)."""
    deviation = targets[split.train].std(0)
    wanted, unit = targets[split.validation], np.where(deviation > 0, deviation, 1)  # so that every target counts alike
    alpha = ridge.best(split.validation, lambda guess: np.mean(((guess - wanted) / unit) ** 2), alphas)
    return _scored(lambda some: ridge.at(some, alpha), alpha, targets, split)


def operator_features(operators: ArrayLike) -> Float[np.ndarray, "n d"]:
    """(n, channels, m, m) operators → (n, d) with the same inner products, in float64.

    A symmetric operator is its `entries`, a weighted upper triangle; one that is not is all it has.
    """
    operators = np.asarray(operators, dtype=np.float64)
    if operators.ndim != 4 or operators.shape[2] != operators.shape[3]:
        raise InputError(f"operators must be (n, channels, m, m), got {operators.shape}")
    channels = []
    for channel in operators.swapaxes(0, 1):
        symmetric = _are_symmetric(channel)
        features = entries(torch.from_numpy(channel)).numpy() if symmetric else channel.reshape(len(channel), -1)
        channels.append(features)
    return np.concatenate(channels, axis=1)


def _are_symmetric(operators: Float[np.ndarray, "n m m"]) -> bool:
    """But for a millionth of the largest entry; a few at a time, as there may be many."""
    few = np.array_split(operators, -(-max(len(operators), 1) // TOGETHER))
    largest = max(np.abs(some).max(initial=0) for some in few)
    return all(np.allclose(some, some.swapaxes(1, 2), rtol=0, atol=1e-6 * largest) for some in few)


def _targets(targets: ArrayLike) -> np.ndarray:
    targets = np.asarray(targets, dtype=np.float64)
    if targets.ndim != 2:
        raise InputError(f"targets must be (n, p), got {targets.shape}")
    return targets


def _scored(
    predict: Callable[[np.ndarray], np.ndarray], alpha: float | None, targets: np.ndarray, split: Split
) -> Reference:
    test, validation = (predict(some) - targets[some] for some in (split.test, split.validation))
    return Reference(float(np.mean(test**2)), float(np.mean(np.abs(test))), alpha, float(np.mean(validation**2)), test)
