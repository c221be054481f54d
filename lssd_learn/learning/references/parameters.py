"""What a net has to beat: the mean of the targets, and ridge regression, both in closed form on the same split."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from lssd_learn.errors import InputError
from lssd_learn.learning.references.ridge import ALPHAS, Ridge
from lssd_learn.learning.split import Split


@dataclass(frozen=True)
class Reference:
    """Mean squared and mean absolute error on the test split, over all entries; `alpha` chosen on validation."""

    mse: float
    l1: float
    alpha: float | None = None


def mean_reference(targets: ArrayLike, split: Split) -> Reference:
    """Predict the mean of the training targets for every shape; targets are (n, p)."""
    targets = _targets(targets)
    return _score(targets[split.train].mean(0), targets[split.test])


def ridge_reference(
    features: ArrayLike, targets: ArrayLike, split: Split, alphas: Sequence[float] = ALPHAS
) -> Reference:
    """Ridge regression (see `Ridge`) of the strength that is best on the validation split.

    Args:
        features: (n, d), such as `operator_features` gives. Scaling them all changes nothing.
        targets: (n, p).
        split: train fits, validation chooses a, test is scored.
        alphas: the a to choose from.
    """
    targets = _targets(targets)
    ridge = Ridge.fit(features, targets, split.train)
    if ridge.is_constant:
        return mean_reference(targets, split)
    errors = [np.mean((ridge.predict(split.validation, a) - targets[split.validation]) ** 2) for a in alphas]
    alpha = float(alphas[int(np.argmin(errors))])
    return _score(ridge.predict(split.test, alpha), targets[split.test], alpha)


def operator_features(operators: ArrayLike) -> np.ndarray:
    """(n, channels, m, m) operators → (n, d) with the same inner products, in float64.

    A symmetric operator is its upper triangle, weighted by √2 off the diagonal; one that is not is all its entries.
    """
    operators = np.asarray(operators, dtype=np.float64)
    if operators.ndim != 4 or operators.shape[2] != operators.shape[3]:
        raise InputError(f"operators must be (n, channels, m, m), got {operators.shape}")
    rows, columns = np.triu_indices(operators.shape[-1])
    weights = np.where(rows == columns, 1.0, np.sqrt(2.0))
    channels = []
    for channel in operators.swapaxes(0, 1):
        symmetric = np.allclose(channel, channel.swapaxes(1, 2), rtol=0, atol=1e-6 * np.abs(channel).max(initial=0))
        channels.append(channel[:, rows, columns] * weights if symmetric else channel.reshape(len(channel), -1))
    return np.concatenate(channels, axis=1)


def _targets(targets: ArrayLike) -> np.ndarray:
    targets = np.asarray(targets, dtype=np.float64)
    if targets.ndim != 2:
        raise InputError(f"targets must be (n, p), got {targets.shape}")
    return targets


def _score(prediction: np.ndarray, truth: np.ndarray, alpha: float | None = None) -> Reference:
    error = prediction - truth
    return Reference(mse=float(np.mean(error**2)), l1=float(np.mean(np.abs(error))), alpha=alpha)
