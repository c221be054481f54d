"""What a reader gives."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int


@dataclass(frozen=True, eq=False)
class Parsed:
    """Vertices and faces as the file has them, not yet checked.

    Attributes:
        vertices: (V, 3) float64.
        faces: (F, 3) int64, none for a cloud.
        notes: what was left out or guessed, in short phrases.
        space: "LPS" or "RAS" where the file says it elsewhere than in its first lines.
        colours: (V, 3) red, green and blue, 0 to 1, of a PLY that has them.
    """

    vertices: Float[np.ndarray, "V 3"]
    faces: Int[np.ndarray, "F 3"]
    notes: tuple[str, ...] = ()
    space: str = ""
    colours: Float[np.ndarray, "V 3"] | None = None


def some(number: int, thing: str) -> str:
    """`1 face`, `2,000 faces`."""
    return f"{number:,} {thing}" if number == 1 else f"{number:,} {thing}s"
