"""What a field says, in words: which group is larger, where more than chance tells, on how much of the surface."""

import numpy as np
from numpy.typing import ArrayLike

from lssd_learn.exploration.models.points import PointField

# What is said of more and of less of what an operator measures; of operators of other kinds "more" and "less".
WORDS = {"area": ("larger", "smaller")}


def in_words(kind: str, field: PointField, mass: ArrayLike) -> str:
    """Such as "m - f: m is larger than f by up to 8.1 % on 12 % of the area, smaller by up to 2.0 % on 3 %".

    Counted is what is significant by the largest statistic.

    Args:
        kind: of operator.
        field: of a term.
        mass: (V,) area of the vertices.
    """
    area = np.asarray(mass, dtype=float) / np.sum(mass)
    subject, _, other = field.title.partition(" - ")
    if not field.title:
        subject = f"{field.term} matters"
        share = 100 * area[field.significant].sum()
        return f"{subject} on {share:.0f} % of the area" if share else f"{field.term}: nothing more than chance"
    other, _, number = other.partition(", ")
    if not other:
        subject, beside = f"with {field.title} more, shapes are", ""
    elif number:
        subject, beside = f"with {number} more, {subject} grows", f" than {other}"
    else:
        subject, beside = f"{subject} is", f" than {other}"
    parts = []
    for sign, word in zip((1, -1), WORDS.get(kind, ("more", "less")), strict=True):
        there = field.significant & (sign * field.effect > 0)
        if there.any():
            most = 100 * abs(np.expm1(sign * (sign * field.effect[there]).max()))
            parts.append(f"{word}{'' if parts else beside} by up to {most:.1f} % on {100 * area[there].sum():.0f} %")
    if not parts:
        return f"{field.title}: nothing more than chance"
    parts[0] += " of the area"
    return f"{subject} {', '.join(parts)}"
