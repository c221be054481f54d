"""Last step of carrying: how far off a landmark may be, from how far those are that are known."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from lssd_learn.maps.carrying.consensus import Consensus

PRIOR = 2.0  # shapes that the mean over all landmarks counts as, beside those that show a landmark's own error
ENOUGH = 3.0  # times the median error, of its name and of all: more is taken for a slip of the hand that placed it
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
        far = np.argwhere(np.nan_to_num(self.errors) > _most(self.errors))
        return sorted(((h, mark) for h, mark in far.tolist()), key=lambda one: -self.errors[one])


def unrest(before: Consensus, after: Consensus) -> Float[np.ndarray, " L"]:
    """(L,) how much is not settled of each landmark of a shape, in its units; NaN of fewer than two hubs.

    How much hubs disagree when their patches have settled, and how far these went to do so. How much maps disagree
    before tells less: most of that is mended.
    """
    moved = np.square(after.points - before.points).sum(axis=1)
    return np.sqrt(after.spread**2 + moved)


def doubts(errors: Float[np.ndarray, "H L"], unrests: Float[np.ndarray, "H L"]) -> Doubts | None:
    """What errors of known landmarks, each carried from the others, tell; None of fewer than three shapes.

    Args:
        errors: of H shapes, NaN where nothing is known.
        unrests: of the same.
    """
    both = np.isfinite(errors) & np.isfinite(unrests)
    if not both.any():
        return None
    errors = np.where(both, errors, np.nan)
    e = np.nan_to_num(np.minimum(errors, _most(errors))) ** 2
    u = np.where(both, unrests, 0.0) ** 2
    count, total = both.sum(axis=0), both.sum()
    square, rest = ((x.sum(axis=0) + PRIOR * x.sum() / total) / (count + PRIOR) for x in (e, u))
    return Doubts(errors, square, rest)


def _most(errors: Float[np.ndarray, "H L"]) -> Float[np.ndarray, " L"]:
    """(L,) the error from which on a landmark of each name is taken for a slip."""
    own = [np.median(column[np.isfinite(column)]) if np.isfinite(column).any() else 0.0 for column in errors.T]
    return ENOUGH * np.maximum(np.nanmedian(errors), own)
