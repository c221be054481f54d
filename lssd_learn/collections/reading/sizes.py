"""Shapes of another size than the rest of their folder: in millimetres among metres, most likely. For `folder.py`."""

from collections.abc import Sequence

import numpy as np

from lssd_learn.errors import some_of
from lssd_learn.shapes import Shape

APART = np.log(4.0)  # between the sizes of neighbours, sorted: no such step is within one kind of shape
NEARLY = 0.2  # of the logarithm of a factor between units
# Length units in millimetres, those that people mix up.
UNITS = {"µm": 1e-3, "mm": 1.0, "cm": 10.0, "inches": 25.4, "feet": 304.8, "m": 1000.0}
# Which pairs a factor stands for, the likeliest first.
PAIRS = (("mm", "m"), ("mm", "cm"), ("cm", "m"), ("mm", "inches"), ("cm", "inches"), ("inches", "m"), ("feet", "m"),
    ("mm", "feet"), ("inches", "feet"), ("cm", "feet"), ("µm", "mm"), ("µm", "m"))  # fmt: skip


def size(shape: Shape) -> float:
    """How large a shape is, the diagonal of its box, in its unit of length."""
    return float(np.linalg.norm(np.ptp(shape.points, axis=0)))


def odd_sizes(names: Sequence[str], sizes: Sequence[float]) -> list[str]:
    """A line for each set of shapes that are several times larger or smaller than most.

    Sizes are sorted; where one is four times the one before or more, or, beside sizes that are all alike, 2.3 times,
    another set begins. Sets count as odd if they are farther from most than these vary among themselves.

    Args:
        names: of n shapes.
        sizes: (n,) of them, above 0.
    """
    logs = np.log(np.maximum(np.asarray(sizes, dtype=float), np.finfo(float).tiny))
    order = np.argsort(logs, kind="stable")
    steps = np.diff(logs[order])
    cuts = np.flatnonzero(steps > APART)
    if not len(cuts) and len(steps) > 4:
        # Inches among centimetres: one wide step, and most sizes on one side of it, which hardly vary.
        widest = int(np.argmax(steps))
        most = max(np.split(logs[order], [widest + 1]), key=len)
        if len(most) > 4 and steps[widest] > max(np.log(2.3), 8 * np.std(most)):
            cuts = np.array([widest])
    sets = np.split(order, cuts + 1)
    most = max(sets, key=len)
    usual, least = np.median(logs[most]), 4 * np.std(logs[most]) if len(most) > 1 else np.log(8)
    lines = []
    for members in sets:
        size = np.median(logs[members])
        if members is not most and abs(size - usual) > least:
            some: list[int] = sorted(members.tolist())
            who = some_of([names[i] for i in some], 3)
            rest = f"the {len(most):,} others" if len(members) + len(most) == len(order) else f"{len(most):,} others"
            lines.append(
                f"{who} {'is' if len(some) == 1 else 'are'} {times(size - usual)} than {rest} "
                f"({np.exp(size):.4g} against {np.exp(usual):.4g} across){unit_guess(size - usual)}"
            )
    return lines


def times(step: float) -> str:
    """How many times larger, or smaller, exp(step) is."""
    factor = np.exp(abs(step))
    number = f"{factor:,.0f}" if factor > 99 else f"{factor:.3g}"
    return f"{number} times {'larger' if step > 0 else 'smaller'}"


def unit_guess(step: float, others: str = "the others") -> str:
    """What units make a shape larger by exp(step) than `others`, as the end of a sentence."""
    distances = []
    for small, large in PAIRS:
        factor = np.log(UNITS[large] / UNITS[small])
        distances.append((abs(abs(step) - factor), small, large))
    # All units that could be: of the likelier pair first, another only if it is nearer by far.
    distance, small, large = min(distances, key=lambda item: round(item[0] / NEARLY))
    if distance > 2.5 * NEARLY:
        return ": in another unit?"
    inside, outside = (small, large) if step > 0 else (large, small)
    return f": in {inside}, {others} in {outside}?"
