"""What nobody said and the operators show: columns whose shapes belong together, and columns that rule what varies.

Both are guesses, told as warnings by the tasks that count shapes as independent.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy.typing import ArrayLike
from scipy.stats import binomtest
from torch import Tensor

from lssd_learn.exploration.embed import pca

# A column may be one of blocks if at least half of its labels are on so many shapes.
REPEATS = (2, 10)
# Nearest neighbours share a label so much more often than chance, and less often than this by chance.
OFTENER, CHANCE = 2.0, 1e-3
# Correlation of a column with a principal component above which it is told; and the fewest shapes a label on average.
RULES, FEWEST = 0.9, 4


@dataclass(frozen=True)
class Belonging:
    """A column that looks like blocks: `shared`, the part of the shapes whose nearest other has the same label, and
    `chance`, the part that would if labels were handed out at random."""

    name: str
    shared: float
    chance: float


def whole_numbers(parameters: ArrayLike | None, names: Sequence[str]) -> dict[str, np.ndarray]:
    """The parameters that may be labels of something: name → (n,) those columns that hold whole numbers."""
    if parameters is None:
        return {}
    columns = dict(zip(names, np.asarray(parameters, dtype=float).T, strict=True))
    return {name: column.astype(int) for name, column in columns.items() if np.all(column == np.round(column))}


def belonging(D: Float[Tensor, "n *channels m m"], columns: Mapping[str, ArrayLike]) -> list[Belonging]:
    """The columns that look like blocks, the clearest first.

    Args:
        D: (n, channels, m, m) operators, or (n, m, m); each channel counts the same.
        columns: name → n labels.
    """
    repeated = {name: labels for name, labels in columns.items() if _repeats(labels)}
    if not repeated or len(D) < 4:
        return []
    nearest = _distances(D).argmin(1)
    found = []
    for name, labels in repeated.items():
        labels = np.asarray(labels).astype(str)
        _, counts = np.unique(labels, return_counts=True)
        n, chance = len(labels), float((counts * (counts - 1)).sum() / (len(labels) * (len(labels) - 1)))
        same = int((labels[nearest] == labels).sum())
        if same / n > OFTENER * chance and binomtest(same, n, chance, "greater").pvalue < CHANCE:
            found.append(Belonging(name, same / n, chance))
    return sorted(found, key=lambda each: each.chance / each.shared)


def alike_within(targets: ArrayLike, labels: ArrayLike) -> bool:
    """Whether some target (n, p), or (n,) classes, hardly varies within labels (n,): less than a quarter as it does."""
    values = np.asarray(targets)
    if values.ndim == 1:  # classes
        values = (values[:, None] == np.unique(values)).astype(float)
    labels = np.unique(np.asarray(labels).astype(str), return_inverse=True)[1]
    within = (
        values
        - np.stack([np.bincount(labels, column) for column in values.T], 1)[labels] / np.bincount(labels)[labels, None]
    )
    varies = values.var(0) > 0
    return bool(np.any((within**2).mean(0)[varies] < values.var(0)[varies] / 4))


def ruling(D: Float[Tensor, "n m m"], columns: Mapping[str, ArrayLike]) -> list[tuple[str, int, float]]:
    """(column, 1 or 2, correlation) of the columns that the first or second principal component follows.

    The correlation is the root of the part of the component's variance between labels, less what as many labels would
    take by chance.

    Args:
        D: (n, m, m) operators.
        columns: name → n labels.
    """
    if not columns:
        return []
    points, found = pca(D).points.cpu().numpy(), []
    for name, labels in columns.items():
        labels = np.unique(np.asarray(labels).astype(str), return_inverse=True)[1]
        n, groups = len(labels), labels.max() + 1
        if groups < 2 or n < FEWEST * groups:
            continue
        for axis in (0, 1):
            x = points[:, axis]
            means = np.bincount(labels, x) / np.bincount(labels)
            total = x.var()
            between = 1 - ((x - means[labels]) ** 2).mean() / total * (n - 1) / (n - groups) if total > 0 else 0
            if between > RULES**2:
                found.append((name, axis + 1, float(np.sqrt(between))))
                break
    return found


def _repeats(labels: ArrayLike) -> bool:
    _, counts = np.unique(np.asarray(labels).astype(str), return_counts=True)
    fits = (counts >= REPEATS[0]) & (counts <= REPEATS[1])
    return len(counts) > 2 and fits.mean() >= 0.5


def _distances(D: Tensor) -> np.ndarray:
    """(n, n) squared, infinite from a shape to itself."""
    channels = D[:, None] if D.ndim == 3 else D
    total = np.zeros((len(D), len(D)))
    for c in range(channels.shape[1]):
        x = channels[:, c].double().flatten(1).cpu().numpy()
        x = x - x.mean(0)
        products, squares = x @ x.T, (x**2).sum(1)
        total = total + (squares[:, None] + squares - 2 * products) / max(squares.mean(), np.finfo(float).tiny)
    np.fill_diagonal(total, np.inf)
    return total
