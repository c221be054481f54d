"""Groups compared in pairs: how far apart their means and slopes are as shapes, and how much more one group varies."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float

from lssd_learn.exploration.models.contrasts import Contrast, contrasts, weights
from lssd_learn.exploration.models.design import ModelDesign, ModelTerm
from lssd_learn.exploration.models.effects import Chance, corrected
from lssd_learn.exploration.models.residuals import permuted_products
from lssd_learn.exploration.models.strata import Stratum, bases, orthonormal

DISTANCE, ANGLE, VARIANCE = "distance", "angle in degrees", "difference of variances"


@dataclass(frozen=True, eq=False)
class Compared:
    """One comparison.

    Attributes:
        term: that it is about.
        what: "distance" between means or slopes (of 1 sd of a number: the length of the slope), "angle in degrees"
            between slopes, "difference of variances".
        pair: of which groups.
        value: with its sign, where it has one.
        chance: its size under permutations.
    """

    term: str
    what: str
    pair: str
    value: float
    chance: Chance


def compare_pairs(Y: Float[np.ndarray, "n r"], design: ModelDesign, parts: Sequence[Stratum]) -> list[Compared]:
    """All there is to compare in a model of vectors, each term in the stratum in which it varies.

    Least-squares means and slopes are those of the whole model; residuals are permuted of the model without the term
    and those that contain it, as for sums of squares of type II.
    """
    found = []
    for term in design.terms:
        part, U, R = place(parts, design, term)
        asked = [(c, a) for c in contrasts(design, term) if (a := weights(part, c.row)) is not None]
        if asked and U is not None and R is not None:
            found += _distances(part, part.carry @ Y, R, term, asked)
            found += _angles(part, part.carry @ Y, R, design, term)
    whole = parts[-1]
    if not whole.name:
        for name in [term.name for term in design.terms if term.factors <= set(design.factors)]:
            term = next(term for term in design.terms if term.name == name)
            found += _variances(whole, whole.carry @ Y, design, term)
    return found


def place(
    parts: Sequence[Stratum], design: ModelDesign, term: ModelTerm
) -> tuple[Stratum, Float[np.ndarray, "u q"] | None, Float[np.ndarray, "u k"] | None]:
    """The last stratum in which a term adds something, as within blocks rather than between them; what it adds there
    and the others, orthonormal."""
    for part in reversed([part for part in parts if part.rest > 0]):
        for name, U, R in bases(part, design, "II"):
            if name == term.name:
                return part, U, R
    return parts[-1], None, None


def rows(kind: str, compared: Sequence[Compared]) -> list[dict[str, Any]]:
    """A row a comparison, p corrected over all of one term that ask the same."""
    families: dict[tuple[str, str], list[Compared]] = {}
    for one in compared:
        families.setdefault((one.term, one.what), []).append(one)
    found: list[dict[str, Any]] = []
    for (term, what), family in families.items():
        together = corrected(np.stack([one.chance.found for one in family]))
        for one, p in zip(family, together.tolist(), strict=True):
            found.append(
                {"operator": kind, "term": term, "what": what, "pair": one.pair, "value": one.value, "Z": one.chance.Z,
                 "p": one.chance.p, "p corrected": p}
            )  # fmt: skip
    return found


def _distances(
    part: Stratum, Y: np.ndarray, R: np.ndarray, term: ModelTerm, asked: Sequence[tuple[Contrast, np.ndarray]]
) -> list[Compared]:
    A = np.stack([a for _, a in asked], 1)
    lengths = _permuted(part, Y, R, A, lambda vectors: np.linalg.norm(vectors, axis=2))
    return [
        Compared(term.name, DISTANCE, c.title, float(found[0]), Chance(found, part.exact))
        for (c, _), found in zip(asked, lengths.T, strict=True)
    ]


def _angles(part: Stratum, Y: np.ndarray, R: np.ndarray, design: ModelDesign, term: ModelTerm) -> list[Compared]:
    """Between the slopes of groups; under permutations all have the common slope, and what is permuted beside it."""
    numbers = [name for name in design.numbers if name in term.factors]
    factors = [name for name in design.factors if name in term.factors]
    if len(numbers) != 1 or not factors or len(numbers) + len(factors) < len(term.factors):
        return []
    groups = design.groups(factors)
    each = [weights(part, row) for row in design.slope_rows(numbers[0], factors, groups)]
    told = [(" ".join(labels), a) for labels, a in zip(groups, each, strict=True) if a is not None]
    if len(told) < 2:
        return []
    A = np.stack([a for _, a in told], 1)
    first, second = np.triu_indices(len(told), 1)

    def angles(vectors: np.ndarray) -> np.ndarray:
        units = vectors / np.linalg.norm(vectors, axis=2, keepdims=True)
        cosines = np.matmul(units, units.transpose(0, 2, 1))[:, first, second]
        return np.degrees(np.arccos(np.clip(cosines, -1, 1)))

    names = [f"{told[h][0]} - {told[g][0]}, 1 sd of {numbers[0]}" for g, h in zip(first, second, strict=True)]
    found = _permuted(part, Y, R, A, angles)
    return [
        Compared(term.name, ANGLE, name, float(of[0]), Chance(of, part.exact))
        for name, of in zip(names, found.T, strict=True)
    ]


def _permuted(
    part: Stratum, Y: np.ndarray, R: np.ndarray, A: np.ndarray, ask: Callable[[np.ndarray], np.ndarray]
) -> np.ndarray:
    """(N, K) of what is asked of AᵀY* (M, K', r), Y* the data under permutations."""
    Q = orthonormal(part.X)
    fitted = R @ (R.T @ Y)
    base, inner = A.T @ fitted, Q.T @ A
    return np.concatenate([ask(base + np.matmul(inner.T, T)) for _, T in permuted_products(Y - fitted, Q, part.rows)])


def _variances(part: Stratum, Y: np.ndarray, design: ModelDesign, term: ModelTerm) -> list[Compared]:
    """Mean squared residuals of groups (Procrustes variance where shapes are Procrustes coordinates), in pairs.

    A residual e of leverage h counts as ‖e‖² / (1 − h), so that small groups do not seem to vary less.
    """
    factors = [name for name in design.factors if name in term.factors]
    Q = orthonormal(part.X)
    free = 1 - np.square(Q).sum(1) - (1 - np.diag(part.carry))
    squares = np.square(Y - Q @ (Q.T @ Y)).sum(1) / np.where(free > 1e-9, free, np.inf)
    labels = list(zip(*(design.values[name] for name in factors), strict=True))
    groups = design.groups(factors)
    member = np.array([[label == group for group in groups] for label in labels], dtype=float)
    means = np.stack([squares @ member[some] for some in part.rows]) / member.sum(0)
    found = []
    for g, h in zip(*np.triu_indices(len(groups), 1), strict=True):
        difference = means[:, h] - means[:, g]
        pair = f"{' '.join(groups[h])} - {' '.join(groups[g])}"
        found.append(Compared(term.name, VARIANCE, pair, float(difference[0]), Chance(np.abs(difference), part.exact)))
    return found
