"""What a term of a model says in numbers: how much larger one group than another, how much more with a number.

Of numbers it is asked per standard deviation: a unit of log(size) is more than there is of it.

A contrast is a row c of the design; of data Y = XB it asks for cB, which is aᵀY with a = X⁺ᵀc.
"""

from dataclasses import dataclass
from itertools import combinations

import numpy as np
from jaxtyping import Float

from lssd_learn.exploration.models.design import ModelDesign, ModelTerm
from lssd_learn.exploration.models.strata import NOTHING, Stratum


@dataclass(frozen=True, eq=False)
class Contrast:
    """One number to ask of a design.

    Attributes:
        title: such as "m - f", or "1 sd of log(size)".
        row: (p,) of the design.
    """

    title: str
    row: Float[np.ndarray, " p"]


def contrasts(design: ModelDesign, term: ModelTerm, most: int | None = None) -> list[Contrast]:
    """What there is to ask of a term.

    Of a number, its slope, the mean over the levels of factors it is multiplied with; of a factor or a product of
    factors, the differences of least-squares means of every two groups; of a number times factors, the differences of
    slopes. Of anything else, as a product of numbers or a polynomial, nothing: it has an F alone.

    Args:
        design: with the term.
        term: of it.
        most: of more pairs of groups none is asked about.
    """
    numbers = [name for name in design.numbers if name in term.factors]
    factors = [name for name in design.factors if name in term.factors]
    if len(numbers) + len(factors) < len(term.factors) or len(numbers) > 1:
        return []
    if numbers and not factors:
        return [
            Contrast(
                f"1 sd of {numbers[0]}", deviation(design, numbers[0]) * design.slope_rows(numbers[0], [], [()])[0]
            )
        ]
    groups = design.groups(factors)
    if most is not None and len(groups) * (len(groups) - 1) // 2 > most:
        return []
    if numbers:
        rows = deviation(design, numbers[0]) * design.slope_rows(numbers[0], factors, groups)
    else:
        rows = design.mean_rows(factors, groups)
    named = [" ".join(labels) for labels in groups]
    what = f", 1 sd of {numbers[0]}" if numbers else ""
    pairs = combinations(range(len(groups)), 2)
    return [Contrast(f"{named[h]} - {named[g]}{what}", rows[h] - rows[g]) for g, h in pairs]


def deviation(design: ModelDesign, number: str) -> float:
    """The standard deviation of a number over the shapes."""
    return float(np.std(design.values[number].astype(float), ddof=1))


def weights(stratum: Stratum, row: Float[np.ndarray, " p"]) -> Float[np.ndarray, " u"] | None:
    """a (u,) with aᵀY = cB in the least-squares fit Y ≈ XB of a stratum; None where this is not told by its units."""
    c = row / stratum.scale
    a = np.linalg.pinv(stratum.X.T, rcond=NOTHING) @ c
    return a if np.linalg.norm(stratum.X.T @ a - c) <= 1e-6 * np.linalg.norm(c) and a.any() else None
