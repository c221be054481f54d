"""Meshes that move on a page: a mean and modes, whose coefficients a script sets. `page/moving.js` reads them.

The viewer draws what `MovingMesh.at(coefficients)` gives: `viewer.move(0, mesh.at(…))`. A mode takes two bytes a
coordinate, so that forty modes of 12,000 vertices are four megabytes.
"""

import numpy as np
from jaxtyping import Float

from lssd_learn.view.reports.stage import encode

MOST_VERTICES = 20_000  # a page; of more, see `thin`
MOST_BYTES = 7_000_000  # of modes


def most_modes(vertices: int) -> int:
    """How many modes of a mesh of so many vertices fit a page."""
    return max(1, MOST_BYTES // (6 * vertices))


def moving_mesh(mean: Float[np.ndarray, "V 3"], modes: Float[np.ndarray, "r V 3"]) -> dict:
    """What `MovingMesh` is made of, for JSON: {mean, modes, scales}.

    Args:
        mean: as it is drawn: upright, about the middle.
        modes: turned alike; what a coefficient of one adds to the mean.
    """
    scales = np.maximum(np.abs(modes).max(axis=(1, 2)), np.finfo(np.float32).tiny) / 32767
    return {
        "mean": encode(mean.astype("<f4")),
        "modes": [encode(np.round(mode / scale).astype("<i2")) for mode, scale in zip(modes, scales, strict=True)],
        "scales": scales.tolist(),
    }
