"""A function on a few shapes with the colours it is shown in: what pictures, coloured meshes and reports share."""

from collections.abc import Sequence
from dataclasses import dataclass

import matplotlib
import numpy as np

from lssd_learn.errors import InputError

SIGNED, SQUARED = "coolwarm", "OrRd"
# The part of the area within the ends of the colours, or of the vertices where areas are not known: a spike at a finger
# tip, or slivers of debris in a scan, would leave the rest pale.
WITHIN = 0.998


@dataclass(frozen=True)
class Field:
    """A function on several shapes.

    Attributes:
        name: short, for file names, such as area_region.
        title: for people.
        values: one (V,) float64 a shape.
        limits: the values at the ends of the colours, of all shapes alike.
        colormap: of matplotlib.
        unit: what its numbers are, beside the colour bar; empty where only more and less means something.
    """

    name: str
    title: str
    values: Sequence[np.ndarray]
    limits: tuple[float, float]
    colormap: str
    unit: str = ""

    @classmethod
    def signed(
        cls, name: str, title: str, values: Sequence[np.ndarray], areas: Sequence[np.ndarray] | None = None
    ) -> "Field":
        """Blue below zero, red above it, as far down as up; areas are those of the vertices, (V,) a shape."""
        most = _most(values, areas)
        return cls(name, title, [np.asarray(v) for v in values], (-most, most), SIGNED)

    @classmethod
    def squared(
        cls, name: str, title: str, values: Sequence[np.ndarray], areas: Sequence[np.ndarray] | None = None
    ) -> "Field":
        """The sums of squares of values (V, p) a shape, pale where they are nothing and red where they are large."""
        return cls.positive(name, title, [np.square(v).sum(1) for v in values], areas)

    @classmethod
    def positive(
        cls,
        name: str,
        title: str,
        values: Sequence[np.ndarray],
        areas: Sequence[np.ndarray] | None = None,
        unit: str = "",
    ) -> "Field":
        """Values from zero on, pale where they are nothing and red where they are large."""
        return cls(name, title, [np.asarray(v) for v in values], (0.0, _most(values, areas)), SQUARED, unit)

    def places(self, i: int) -> np.ndarray:
        """(V,) places of the values of shape i in the colours, 0 to 1."""
        low, high = self.limits
        return np.clip((self.values[i] - low) / (high - low), 0, 1)

    def colours(self, i: int) -> np.ndarray:
        """(V, 3) uint8 at the vertices of shape i."""
        return np.round(255 * matplotlib.colormaps[self.colormap](self.places(i))[:, :3]).astype(np.uint8)


def unit_of_change(kind: str) -> str:
    """What a change of an operator at a point is in, by the kind of the operator, such as "area"."""
    return "part of the area" if kind == "area" else "relative change"


def _most(values: Sequence[np.ndarray], areas: Sequence[np.ndarray] | None = None) -> float:
    if not len(values):
        raise InputError("values: expected a function on one shape at least, got none")
    size = np.abs(np.concatenate(values))
    if areas is None:
        return float(np.quantile(size, WITHIN)) or 1.0
    weights = np.concatenate([np.asarray(area) / np.sum(area) for area in areas])
    return float(np.quantile(size, WITHIN, weights=weights, method="inverted_cdf")) or 1.0
