"""SciPy's k-d tree with types: the compiled class comes without any, and a type checker would not find it."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import ArrayLike

    class cKDTree:
        """`scipy.spatial.cKDTree`, as much of it as is used here."""

        indices: np.ndarray

        def __init__(self, data: ArrayLike) -> None: ...

        def query(self, x: ArrayLike, k: int = 1, workers: int = 1) -> tuple[np.ndarray, np.ndarray]:
            """Distances and indices of the k nearest: (m,) each, or (m, k) where k is above 1."""
            ...

        def query_ball_point(self, x: ArrayLike, r: float) -> np.ndarray:
            """A list of the indices within r of one point, or an array of such lists, of many points."""
            ...

        def query_pairs(self, r: float, output_type: str) -> np.ndarray:
            """(p, 2) the pairs within r of each other, where the output is "ndarray"."""
            ...

else:
    from scipy.spatial import cKDTree

__all__ = ["cKDTree"]
