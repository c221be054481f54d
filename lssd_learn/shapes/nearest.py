"""Points and what is nearest to them: the distance between two clouds where no gradient is asked for.

`nets.chamfer` is the same with gradients.
"""

import numpy as np
from jaxtyping import Float, Int
from numpy.typing import ArrayLike

from lssd_learn.kdtree import cKDTree


class Indexed:
    """Points (N, 3) that are compared with others, sorted once.

    Attributes:
        points: (N, 3).
    """

    def __init__(self, points: ArrayLike):
        self.points = np.asarray(points)
        self._tree = cKDTree(self.points)

    def __len__(self) -> int:
        return len(self.points)

    def nearest(self, queries: Float[np.ndarray, "M 3"]) -> tuple[Float[np.ndarray, " M"], Int[np.ndarray, " M"]]:
        """Of each query (M, 3) the distance to the nearest of the points, and which that is: (M,) and (M,)."""
        return self._tree.query(queries)

    def distances(self, queries: Float[np.ndarray, "M 3"]) -> Float[np.ndarray, " M"]:
        """(M,) from each query (M, 3) to the nearest of the points."""
        return self._tree.query(queries)[0]

    def chamfer(self, other: "Indexed") -> float:
        """The mean squared distance to the nearest point of the other cloud, plus the same the other way."""
        return float(np.mean(other.distances(self.points) ** 2) + np.mean(self.distances(other.points) ** 2))
