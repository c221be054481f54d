"""What a reader of body measures knows a body by: how far apart points of it are, along chords as long as a hand or a
forearm. Shorter ones tell mostly how a map slides, longer ones how the body is bent.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra

from lssd_learn.shapes.edges import edges

SHORT, LONG = 0.1, 0.4  # metres, along the edges


@dataclass(frozen=True)
class Chords:
    """Pairs of vertices of bodies of the same faces.

    Attributes:
        pairs: (d, 2).
    """

    pairs: Int[np.ndarray, "d 2"]

    @classmethod
    def of(
        cls, bodies: Float[np.ndarray, "n V 3"], faces: Int[np.ndarray, "F 3"], count: int, seed: int = 0
    ) -> "Chords":
        """So many, drawn at random among those of `SHORT` to `LONG` metres on average; all, where there are fewer."""
        a, b = edges(faces).T
        lengths, v = np.linalg.norm(bodies[:, a] - bodies[:, b], axis=2).mean(axis=0), bodies.shape[1]
        away = dijkstra(coo_array((lengths, (a, b)), shape=(v, v)).tocsr(), directed=False, limit=LONG)
        found = np.argwhere(np.triu((away > SHORT) & (away < LONG)))
        drawn = np.random.default_rng(seed).permutation(len(found))[:count]
        return cls(found[np.sort(drawn)])

    def __call__(self, points: Float[np.ndarray, "n V 3"]) -> Float[np.ndarray, "n d"]:
        """(n, d) logarithms of the distances in metres, of which a millimetre is the least."""
        a, b = self.pairs.T
        return np.log(np.maximum(np.linalg.norm(points[:, a] - points[:, b], axis=2), 1e-3))
