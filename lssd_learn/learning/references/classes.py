"""What a classifier has to beat: the most frequent class, and a linear classifier in closed form on the same split."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from lssd_learn.division.split import Split
from lssd_learn.errors import InputError
from lssd_learn.learning.references.ridge import ALPHAS, Ridge


@dataclass(frozen=True)
class ClassReference:
    """Share of the test split that is right; `alpha` chosen on validation."""

    accuracy: float
    alpha: float | None = None


def majority_reference(labels: ArrayLike, split: Split) -> ClassReference:
    """Answer the most frequent class of the training split for every shape; labels are (n,) integers from 0."""
    labels = _labels(labels)
    answer = np.bincount(labels[split.train]).argmax()
    return ClassReference(float(np.mean(labels[split.test] == answer)))


def linear_reference(
    features: ArrayLike, labels: ArrayLike, split: Split, alphas: Sequence[float] = ALPHAS
) -> ClassReference:
    """A linear classifier: ridge regression (see `Ridge`) to one indicator a class; the largest is the answer.

    Args:
        features: (n, d), such as `operator_features` gives. Scaling them all changes nothing.
        labels: (n,) integers from 0.
        split: train fits, validation chooses the strength, test is scored.
        alphas: the strengths to choose from; of those with as many right, the one with the least squared error.
    """
    labels = _labels(labels)
    indicators = np.eye(labels.max() + 1)[labels]
    ridge = Ridge.fit(features, indicators, split.train)

    def loss(guess: np.ndarray) -> tuple[float, float]:
        wrong = np.mean(guess.argmax(1) != labels[split.validation])
        return float(wrong), float(np.mean((guess - indicators[split.validation]) ** 2))

    alpha = ridge.best(split.validation, loss, alphas)
    answers = ridge.at(split.test, alpha).argmax(1)
    return ClassReference(float(np.mean(answers == labels[split.test])), alpha)


def _labels(labels: ArrayLike) -> np.ndarray:
    labels = np.asarray(labels)
    if labels.ndim != 1 or labels.dtype.kind not in "iu" or labels.min(initial=0) < 0:
        raise InputError(f"labels must be (n,) integers from 0, got {labels.dtype} {labels.shape}")
    return labels
