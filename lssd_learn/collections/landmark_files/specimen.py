"""The landmarks of one specimen, as a landmark file says them; and what the formats share."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from lssd_learn.collections.reading.numbers import MISSING
from lssd_learn.shapes.reading.words import Numbers

SPACES = {"ras": "RAS", "0": "RAS", "lps": "LPS", "1": "LPS"}  # by what Slicer writes of them
TO_OTHER_SPACE = np.array([-1.0, -1.0, 1.0])  # left for right and posterior for anterior, or back


@dataclass(frozen=True, eq=False)
class Specimen:
    """Landmarks of one specimen.

    Attributes:
        name: of the specimen; "" where the file does not say it.
        labels: names of the L landmarks, each once; "1", "2", … where the file only has their order.
        points: (L, 3) in the units of the file, NaN for a landmark that is missing.
        space: "LPS" or "RAS", the coordinate system, where the file says one; "".
        notes: what was left out or guessed, in short phrases.
    """

    name: str
    labels: tuple[str, ...]
    points: Float[np.ndarray, "L 3"]
    space: str = ""
    notes: tuple[str, ...] = ()

    @property
    def missing(self) -> list[str]:
        """Names of the landmarks without a place."""
        return [label for label, point in zip(self.labels, self.points, strict=True) if np.isnan(point).any()]

    def in_space(self, space: str) -> "Specimen":
        """The same in another coordinate system; as it is where one of the two is not known."""
        if not space or not self.space or space == self.space:
            return self
        return Specimen(self.name, self.labels, self.points * TO_OTHER_SPACE, space, self.notes)


def specimen(
    name: str, labels: Sequence[str], points: Sequence[Sequence[float]], space: str = "", notes: Sequence[str] = ()
) -> Specimen:
    """A `Specimen` of lists.

    Raises:
        ValueError: a landmark without a name, with one of several lines, or two of one name.
    """
    seen: set[str] = set()
    for label in labels:
        if not label or set(label) & set("\n\r\t"):
            raise ValueError(f"expected a name for every landmark, on one line, got {label[:30]!r}")
        if label in seen:
            raise ValueError(f"expected each landmark once, got {label!r} again")
        seen.add(label)
    array = np.array(points, dtype=np.float64).reshape(len(labels), 3)
    array[np.isnan(array).any(axis=1)] = np.nan
    return Specimen(name, tuple(labels), array, space, tuple(notes))


def numbered(n: int) -> list[str]:
    """Names of landmarks that have none: "1", "2", …"""
    return [str(i + 1) for i in range(n)]


def place(words: Sequence[str], numbers: Numbers, missing: float | None = None) -> list[float]:
    """x, y, z of three words; NaN for a landmark that is said to be missing.

    Args:
        words: three; empty ones, NA and the like are numbers nobody knows.
        numbers: of the file.
        missing: the number that the format writes, three times, for a missing landmark.

    Raises:
        ValueError: other than three numbers, or a number in some of the three only.
    """
    unknown = [not word or word.casefold() in MISSING for word in words]
    if len(words) != 3 or (any(unknown) and not all(unknown)):
        raise ValueError(f"expected x, y, z, got {' '.join(words)[:60]!r}")
    if all(unknown):
        return [np.nan] * 3
    try:
        values = numbers.floats(words)
    except ValueError as error:
        raise ValueError(f"expected x, y, z, got {' '.join(words)[:60]!r}: {error}") from None
    if not np.isfinite(values).all():
        raise ValueError(f"expected x, y, z, got {' '.join(words)[:60]!r}")
    return [np.nan] * 3 if missing is not None and set(values) == {missing} else values


def words_of(point: Float[np.ndarray, "3"], missing: str) -> list[str]:
    """x, y, z with every digit, or three times the word for a missing landmark."""
    return [missing] * 3 if np.isnan(point).any() else [repr(float(x)) for x in point]
