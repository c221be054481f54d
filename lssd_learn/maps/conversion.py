"""From a functional map to a vertex map; `from_correspondence` is the way back."""

import numpy as np
from jaxtyping import Float, Int

from lssd_learn.kdtree import cKDTree
from lssd_learn.shapes import Eigenbasis


def to_vertices(source: Eigenbasis, target: Eigenbasis, C: Float[np.ndarray, "l m"]) -> Int[np.ndarray, " V_target"]:
    """(V_target,) for each vertex of the target the vertex of the source: T(y) = argmin_x ‖Φₛ(x) − (Φₜ C)(y)‖.

    A point is known by what all eigenfunctions are there; C says it of the target's points in those of the source.

    Args:
        source, target: eigenbases of at least the functions that C maps.
        C: (l, m) carries the first m functions of `source` to the first l of `target`.

    Raises:
        ValueError: C maps more functions than the bases have.

    Reference:
        Ovsjanikov, Ben-Chen, Solomon, Butscher and Guibas, "Functional maps", ACM Transactions on Graphics 31 (2012).
    """
    rows, columns = C.shape
    if rows > target.k or columns > source.k:
        raise ValueError(f"C: expected at most {target.k} × {source.k} for these bases, got {rows} × {columns}")
    return cKDTree(source.evecs[:, :columns]).query(target.evecs[:, :rows] @ C)[1]
