"""Last step of carrying: how far off a landmark may be, from how far those are that are known."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from lssd_learn.maps.carrying.consensus import Consensus, consensus

PRIOR = 2.0  # shapes that the mean over all landmarks counts as, beside those that show a landmark's own error


@dataclass(frozen=True, eq=False)
class Doubts:
    """What the shapes that have the landmarks tell of the errors of L carried ones.

    Attributes:
        errors: (H, L) how far the landmarks of each of these shapes are from what the others say; NaN where unknown.
        square: (L,) mean square error that is to be expected of each landmark.
        spread: (L,) mean square spread of what was said, when these errors were made.
        steepness: by how much the square error grows with the square spread, in [0, 1].
    """

    errors: Float[np.ndarray, "H L"]
    square: Float[np.ndarray, " L"]
    spread: Float[np.ndarray, " L"]
    steepness: float

    def bars(self, found: Consensus) -> Float[np.ndarray, " L"]:
        """(L,) root mean square errors to be expected, in the units of the shapes; NaN where nothing is known.

        What a landmark's errors were among the shapes that have it, more where these disagree more about this one, and
        fewer shapes than there were.
        """
        excess = self.steepness * (found.spread**2 - self.spread)
        return np.sqrt(np.maximum(self.square + excess, self.square / 4))


def doubts(places: Float[np.ndarray, "H H L 3"], known: Float[np.ndarray, "H L 3"]) -> Doubts | None:
    """What each of H shapes' landmarks, carried from the others, tell; None of fewer than three shapes.

    Args:
        places: [i, h] the landmarks of shape i as shape h says them; NaN where h is i, or says nothing.
        known: where they are; NaN where nobody knows.
    """
    left = [consensus(row) for row in places]
    errors = np.array([np.linalg.norm(one.points - true, axis=1) for one, true in zip(left, known, strict=True)])
    spreads = np.array([one.spread for one in left])
    both = np.isfinite(errors) & np.isfinite(spreads)
    if not both.any():
        return None
    e, s = np.where(both, errors**2, 0.0), np.where(both, spreads**2, 0.0)
    count = both.sum(axis=0)
    square = (e.sum(axis=0) + PRIOR * e.sum() / both.sum()) / (count + PRIOR)
    spread = (s.sum(axis=0) + PRIOR * s.sum() / both.sum()) / (count + PRIOR)
    a, b = (np.where(both, x - middle, 0.0) for x, middle in ((e, square), (s, spread)))
    slope = (a * b).sum() / max((b * b).sum(), np.finfo(float).tiny)
    return Doubts(errors, square, spread, float(np.clip(slope, 0.0, 1.0)))
