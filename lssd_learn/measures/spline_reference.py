"""What anybody can do without maps: a landmark placed by a thin-plate spline through the others.

It has to be told the other landmarks of the shape, which carrying is not.
"""

import numpy as np
from jaxtyping import Float
from scipy.interpolate import RBFInterpolator

from lssd_learn.maps.carrying.consensus import consensus

LEAST = 5  # other landmarks: four fix an affine map, one more bends it
ROUNDING = 1e-9  # over the size of the configuration: two landmarks may lie at one point


def spline_errors(
    hubs: Float[np.ndarray, "H L 3"], shapes: Float[np.ndarray, "m L 3"]
) -> Float[np.ndarray, "m L"] | None:
    """How far off each landmark is where splines through all the others, from the hubs, say it; in their units.

    Args:
        hubs, shapes: known landmarks, none missing.

    Returns:
        None of too few landmarks, or where the others lie in one plane.

    Reference:
        Bookstein, "Principal warps", IEEE Transactions on Pattern Analysis and Machine Intelligence 11 (1989).
    """
    L = hubs.shape[1]
    if L <= LEAST:
        return None
    errors = np.empty(shapes.shape[:2])
    for number, target in enumerate(shapes):
        said = np.empty_like(hubs)
        for mark in range(L):
            others = np.arange(L) != mark
            for h, hub in enumerate(hubs):
                tiny = ROUNDING * float(np.ptp(hub, axis=0).max())
                try:
                    bend = RBFInterpolator(hub[others], target[others], kernel="linear", degree=1, smoothing=tiny)
                except np.linalg.LinAlgError:
                    return None
                said[h, mark] = bend(hub[mark][None])[0]
        errors[number] = np.linalg.norm(consensus(said).points - target, axis=1)
    return errors
