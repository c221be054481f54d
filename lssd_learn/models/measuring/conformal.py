"""Split conformal prediction: intervals that hold with a given probability, whatever the reader and the errors are.

Where calibration shapes and a new one are exchangeable, and the reader has seen none of them, the new error is no
larger than the ⌈(n + 1)(1 − α)⌉-th smallest of n calibration errors with probability 1 − α or more, and at most
1 / (n + 1) more (Vovk, Gammerman & Shafer, Algorithmic Learning in a Random World, 2005; Lei et al., JASA 113, 2018).
"""

import math

import numpy as np
from jaxtyping import Float


def conformal_width(errors: Float[np.ndarray, "n p"], level: float = 0.9) -> Float[np.ndarray, " p"]:
    """(p,) half the width of intervals that hold with probability `level`: infinite if n errors are too few for it.

    Args:
        errors: (n, p) of shapes that nothing was fitted to or chosen on; their signs do not matter.
        level: in (0, 1).
    """
    n = len(errors)
    place = math.ceil(level * (n + 1) - 1e-9)
    if place > n:
        return np.full(errors.shape[1], np.inf)
    return np.sort(np.abs(errors), axis=0)[place - 1]
