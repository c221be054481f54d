"""Bending a mesh: as rigidly as possible, but for a stretch that is learnt on the way."""

import numpy as np
from scipy.sparse import coo_array, csc_array, csr_array, dia_array
from scipy.sparse.linalg import splu

from lssd_learn.maps.matching.prepared import Prepared

LEAST_WEIGHT = 1e-4  # of an edge: cotangents of obtuse angles are negative, and bending needs an energy
TURNS = 3  # rotations and positions in turn, a fit
SPREAD = 20  # rounds of averaging that a stretch is smoothed by
PLASTIC = 0.1  # share of the undeformed in a stretch: keeps flat patches, which say nothing of thickness, as they are


class Elastic:
    """A mesh of V vertices that bends.

    The energy of positions Y is Σ w_ij ‖y_j − y_i − R_ij U_ij (x_j − x_i)‖² over edges, R rotations that suit the place
    best and U the stretch learnt so far (`learn`), none at first.

    Reference:
        Sorkine and Alexa, "As-rigid-as-possible surface modeling", Symposium on Geometry Processing (2007).
    """

    def __init__(self, shape: Prepared):
        self.count = len(shape.points)
        edges = coo_array(shape.stiffness)
        off = edges.row != edges.col
        self.i, self.j = edges.row[off], edges.col[off]
        self.w = np.maximum(-edges.data[off], LEAST_WEIGHT)
        weights = csr_array((self.w, (self.i, self.j)), shape=(self.count, self.count))
        self.degree = weights.sum(axis=1)
        self._laplacian = csc_array(_diagonal(self.degree) - weights)
        self._mean = csr_array(_diagonal(1 / self.degree) @ weights)
        ones = csr_array((np.ones(len(self.i)), (self.i, self.j)), shape=(self.count, self.count))
        self._blur = csr_array(_diagonal(0.5 / ones.sum(axis=1)) @ ones + _diagonal(np.full(self.count, 0.5)))
        self.rest = shape.points[self.j] - shape.points[self.i]
        self.stretched = self.rest
        self.turns = np.broadcast_to(np.eye(3), (self.count, 3, 3))

    def fit(self, goals: np.ndarray, weights: np.ndarray, stiffness: float, start: np.ndarray) -> np.ndarray:
        """(V, 3) positions: least Σ weights ‖y − goals‖² + stiffness · energy, from `start` on.

        Args:
            goals: (V, 3).
            weights: (V,).
            stiffness: at unit area.
            start: (V, 3).
        """
        matrix = csc_array(stiffness * self._laplacian + _diagonal(weights))
        options = {"SymmetricMode": True}
        factors = splu(matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=options)
        positions, pull = start, weights[:, None] * goals
        for _ in range(TURNS):
            self.turns = self._rotations(positions)
            turned = np.einsum("eab,ea->eb", self._between(self.turns), self.stretched) * self.w[:, None]
            positions = factors.solve(pull + stiffness * self._sums(self.j, turned))
        return positions

    def learn(self, positions: np.ndarray) -> None:
        """Take the smooth part of the stretch that these positions (V, 3) show for the shape's own."""
        now = positions[self.j] - positions[self.i]
        pulled = np.einsum("eb,eab->ea", now, self.turns[self.i])
        seen = self._blurred(self._products(self.rest, pulled))
        plain = self._blurred(self._products(self.rest, self.rest))
        anyway = PLASTIC / 3 * np.trace(plain, axis1=1, axis2=2)[:, None, None] * np.eye(3)
        U = np.linalg.solve(plain + anyway, seen + anyway)
        U = (U + U.transpose(0, 2, 1)) / 2
        self.stretched = np.einsum("ea,eab->eb", self.rest, self._between(U))

    def energy(self, positions: np.ndarray) -> float:
        """What bending and stretching the undeformed shape so costs, at unit area: about the mean square strain."""
        now = positions[self.j] - positions[self.i]
        off = now - np.einsum("eab,ea->eb", self._between(self.turns), self.rest)
        return float((self.w * (off**2).sum(axis=1)).sum() / 2)

    def _rotations(self, positions: np.ndarray) -> np.ndarray:
        """(V, 3, 3) R with x R ≈ y for the edges around each vertex and around its neighbours."""
        covariances = self._products(self.stretched, positions[self.j] - positions[self.i])
        flat = covariances.reshape(self.count, 9)
        covariances = (flat + self._mean @ flat).reshape(-1, 3, 3)
        U, _, Vt = np.linalg.svd(covariances)
        U[:, :, 2] *= np.sign(np.linalg.det(U @ Vt))[:, None]
        return U @ Vt

    def _between(self, matrices: np.ndarray) -> np.ndarray:
        """(E, 3, 3) of the edges, from those of their ends."""
        return (matrices[self.i] + matrices[self.j]) / 2

    def _products(self, a: np.ndarray, b: np.ndarray) -> np.ndarray:
        """(V, 3, 3) Σ w a bᵀ over the edges at each vertex."""
        weighted = self.w[:, None] * a
        products = [self._sum(self.i, weighted[:, p] * b[:, q]) for p in range(3) for q in range(3)]
        return np.stack(products, axis=1).reshape(-1, 3, 3)

    def _sums(self, where: np.ndarray, vectors: np.ndarray) -> np.ndarray:
        return np.stack([self._sum(where, column) for column in vectors.T], axis=1)

    def _sum(self, where: np.ndarray, values: np.ndarray) -> np.ndarray:
        return np.bincount(where, values, minlength=self.count)

    def _blurred(self, matrices: np.ndarray) -> np.ndarray:
        flat = matrices.reshape(self.count, 9)
        for _ in range(SPREAD):
            flat = self._blur @ flat
        return flat.reshape(-1, 3, 3)


def _diagonal(values: np.ndarray) -> dia_array:
    return dia_array((values[None], 0), shape=(len(values), len(values)))
