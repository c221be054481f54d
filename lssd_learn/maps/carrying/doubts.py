"""Last step of carrying: how far off a landmark may be, from how far those are that are known."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from lssd_learn.maps.carrying.consensus import Consensus

PRIOR = 2.0  # shapes that the mean over all landmarks counts as, beside those that show a landmark's own error
ENOUGH = 3.0  # times the median error: more of one is taken for a slip of the hand that placed it
STEEP = 0.5  # power of the unrest that the mean square error grows with


@dataclass(frozen=True, eq=False)
class Doubts:
    """What H shapes that have the landmarks tell of the errors of L carried ones.

    Attributes:
        errors: (H, L) how far the landmarks of each of these shapes are from where the others say them; NaN where
            nobody does.
        square: (L,) mean square error that is to be expected of each landmark.
        unrest: (L,) mean square unrest of it, see `unrest`, when these errors were made.
    """

    errors: Float[np.ndarray, "H L"]
    square: Float[np.ndarray, " L"]
    unrest: Float[np.ndarray, " L"]

    def bars(self, unrest: Float[np.ndarray, "m L"]) -> Float[np.ndarray, "m L"]:
        """(m, L) root mean square errors to be expected, in the units of the shapes; NaN where nothing is known.

        What a landmark's errors were among the shapes that have it, and more where there is more unrest than there was.
        """
        least = np.finfo(float).tiny
        return np.sqrt(self.square * (unrest**2 / np.maximum(self.unrest, least)) ** STEEP)

    @property
    def slips(self) -> list[tuple[int, int]]:
        """Number of the shape, of the H, and landmark of given ones that lie far from where the others say.

        Farther than landmarks of this name do, and than landmarks at large.
        """
        whole = np.nanmedian(self.errors)
        own = np.array([np.median(column[np.isfinite(column)]) if np.isfinite(column).any() else 0.0
                        for column in self.errors.T])  # fmt: skip
        far = np.argwhere(np.nan_to_num(self.errors) > ENOUGH * np.maximum(whole, own))
        return sorted(((h, mark) for h, mark in far.tolist()), key=lambda one: -self.errors[one])


def unrest(before: Consensus, after: Consensus) -> Float[np.ndarray, " L"]:
    """(L,) how much is not settled of each landmark of a shape, in its units; NaN of fewer than two hubs.

    How much hubs disagree by their maps, and when their patches have settled, and how far these went to do so.
    """
    moved = np.square(after.points - before.points).sum(axis=1)
    return np.sqrt(before.spread**2 + after.spread**2 + moved)


def doubts(errors: Float[np.ndarray, "H L"], unrests: Float[np.ndarray, "H L"]) -> Doubts | None:
    """What errors of known landmarks, each carried from the others, tell; None of fewer than three shapes.

    Args:
        errors: of H shapes, NaN where nothing is known.
        unrests: of the same.
    """
    both = np.isfinite(errors) & np.isfinite(unrests)
    if not both.any():
        return None
    most = ENOUGH * float(np.median(errors[both]))
    e = np.where(both, np.minimum(np.where(both, errors, 0.0), most) ** 2, 0.0)
    u = np.where(both, unrests, 0.0) ** 2
    count, total = both.sum(axis=0), both.sum()
    square, rest = ((x.sum(axis=0) + PRIOR * x.sum() / total) / (count + PRIOR) for x in (e, u))
    return Doubts(np.where(both, errors, np.nan), square, rest)
