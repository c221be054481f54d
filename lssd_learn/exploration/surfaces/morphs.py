"""One surface becoming another: along a number, from group to group, along a principal component.

All are lines in the space of coordinates: what a term of a model does is a contrast of its linear model, taken of
coordinates as it is of operators, with the same shapes, weights and blocks.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from jaxtyping import Float

from lssd_learn.exploration.models.contrasts import weights
from lssd_learn.exploration.models.design import ModelDesign, ModelTerm
from lssd_learn.exploration.models.pairwise import place
from lssd_learn.exploration.models.points import PAIRS
from lssd_learn.exploration.models.strata import Stratum

FAR = 2.0  # standard deviations from the mean, at the ends of what is written
BEYOND = 2.0  # times as far one may go


@dataclass(frozen=True, eq=False)
class Morph:
    """A line of surfaces x̂ = middle + s · step.

    Attributes:
        title: such as "weight", or "sex: f → m".
        ends: what s = −1 and s = 1 are, such as ("weight = 0.2 (−2 sd)", "weight = 0.8 (+2 sd)").
        middle: (m, 3) coordinates at s = 0.
        step: (m, 3).
        at: the values of a number at s = −1 and s = 1; None where there is none.
    """

    title: str
    ends: tuple[str, str]
    middle: Float[np.ndarray, "m 3"]
    step: Float[np.ndarray, "m 3"]
    at: tuple[float, float] | None = None

    def x(self, s: float) -> Float[np.ndarray, "m 3"]:
        """(m, 3) coordinates of the surface at s."""
        return self.middle + s * self.step


def model_morphs(
    x: Float[np.ndarray, "n m 3"], design: ModelDesign, parts: Sequence[Stratum], like: int
) -> list[Morph]:
    """What each term of a model does to the surface.

    A number goes from two standard deviations below its mean to two above it, by its slope beside all other terms; of a
    number times factors each group has its slope. Of factors every group goes to every other, of up to `PAIRS`. What a
    term is not about stays: numbers at their mean, factors as they are of one shape, for the mean of several poses, or
    of sexes, is no shape that there is. What `contrasts` cannot say, as a polynomial, has none.

    Args:
        x: of the n shapes of the design.
        design: of them.
        parts: its `strata`.
        like: position among the n of the shape whose labels factors keep.
    """
    flat, found = x.reshape(len(x), -1), []
    means = np.linalg.pinv(design.X) @ flat
    for term in design.terms:
        part, U, _ = place(parts, design, term)
        if U is not None:
            for title, ends, row, middle, at in _asked(design, term, like):
                a = weights(part, row)
                if a is not None:
                    step = (a @ (part.carry @ flat)).reshape(x.shape[1:])
                    found.append(Morph(title, ends, (middle @ means).reshape(x.shape[1:]), step, at))
    return found


Line = tuple[str, tuple[str, str], np.ndarray, np.ndarray, tuple[float, float] | None]


def _asked(design: ModelDesign, term: ModelTerm, like: int) -> Iterator[Line]:
    """Title, ends, row of the design for the step, row of it in the middle, values at the ends."""
    numbers = [name for name in design.numbers if name in term.factors]
    factors = [name for name in design.factors if name in term.factors]
    if len(numbers) + len(factors) < len(term.factors) or len(numbers) > 1:
        return
    kept = {name: str(design.values[name][like]) for name in design.factors}
    groups = design.groups(factors) if factors else [()]

    def row(labels: Sequence[str]) -> np.ndarray:
        at = kept | dict(zip(factors, labels, strict=True))
        return design.mean_rows(list(at), [tuple(at.values())])[0]

    if numbers:
        number = numbers[0]
        own = factors or design.factors
        for labels in groups[: PAIRS + 1] if factors else [tuple(kept[name] for name in own)]:
            values = design.values[number].astype(float)
            mean, spread = float(values.mean()), FAR * float(values.std(ddof=1))
            slope = design.slope_rows(number, own, [tuple(labels)])[0] * spread
            ends = (_number(number, mean - spread, -FAR), _number(number, mean + spread, FAR))
            title = f"{number}{' of ' + ' '.join(labels) if factors else ''}"
            middle = row(labels) if factors else row(())
            yield title, ends, slope, middle, (mean - spread, mean + spread)
    elif len(groups) * (len(groups) - 1) // 2 <= PAIRS:
        for g, first in enumerate(groups):
            for second in groups[g + 1 :]:
                low, high = row(first), row(second)
                ends = (" ".join(first), " ".join(second))
                title = f"{term.name}: {ends[0]} → {ends[1]}"
                yield title, ends, (high - low) / 2, (high + low) / 2, None


def _number(name: str, value: float, sd: float) -> str:
    return f"{name} = {value:.4g} ({sd:+g} sd)"


def group_morphs(x: Float[np.ndarray, "n m 3"], name: str, labels: Sequence[str | None]) -> list[Morph]:
    """From the mean of each group to that of each other; of more than `PAIRS` pairs from the mean of all to each.

    Args:
        x: of n shapes.
        name: what they are grouped by.
        labels: n; None is in no group.
    """
    of = np.array([label is not None for label in labels])
    groups = sorted({label for label in labels if label is not None})
    means = {group: x[[label == group for label in labels]].mean(0) for group in groups}
    pairs = list(combinations(groups, 2))
    if len(pairs) > PAIRS:
        means["all"], pairs = x[of].mean(0), [("all", group) for group in groups]
    return [Morph(f"{name}: {a} → {b}", (a, b), (means[a] + means[b]) / 2, (means[b] - means[a]) / 2) for a, b in pairs]


def score_morphs(x: Float[np.ndarray, "n m 3"], scores: Mapping[str, Float[np.ndarray, " n"]]) -> list[Morph]:
    """What goes with each of some scores of the shapes, such as a principal component, by itself.

    From two standard deviations below its mean to two above, by the slope of coordinates on it, which of a principal
    component of the coordinates themselves is the component.

    Args:
        x: of n shapes.
        scores: name → n values; one that is the same for all shapes has none.
    """
    mean, found = x.mean(0), []
    for name, values in scores.items():
        about = np.asarray(values, dtype=float) - np.mean(values)
        spread = FAR * float(about.std(ddof=1))
        if spread > 0:
            step = np.tensordot(about, x, 1) / (about @ about) * spread
            ends = (f"{name} −{FAR:g} sd", f"{name} +{FAR:g} sd")
            at = (float(np.mean(values)) - spread, float(np.mean(values)) + spread)
            found.append(Morph(name, ends, mean, step, at))
    return found
