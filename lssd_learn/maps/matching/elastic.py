"""Bending points that are joined by edges: as rigidly as possible, but for a stretch that is learnt on the way."""

from collections.abc import Callable

import numpy as np
from scipy.sparse import csc_array, csr_array, dia_array
from scipy.sparse.linalg import splu

from lssd_learn.shapes.kabsch import nearest_rotation

TURNS = 3  # rotations and positions in turn, a fit
PLASTIC = 0.1  # share of the undeformed in a stretch: keeps flat patches, which say nothing of thickness, as they are


class Elastic:
    """n points that bend.

    The energy of positions Y is ½ Σ w_ij ‖y_j − y_i − R_ij U_ij (x_j − x_i)‖² over edges, both ways, R rotations that
    suit the place best and U the stretch learnt so far (`learn`), none at first.

    Args:
        points: (n, 3) undeformed.
        i, j, w: (m,) the edges, each from both ends, and their weights above 0.
        blur: rounds of averaging over neighbours that a stretch is smoothed by.

    Reference:
        Sorkine and Alexa, "As-rigid-as-possible surface modeling", Symposium on Geometry Processing (2007).
    """

    def __init__(self, points: np.ndarray, i: np.ndarray, j: np.ndarray, w: np.ndarray, blur: int):
        self.count, self.i, self.j, self.w, self.blur = len(points), i, j, w, blur
        weights = csr_array((w, (i, j)), shape=(self.count, self.count))
        degree = weights.sum(axis=1)
        self._laplacian = csc_array(_diagonal(degree) - weights)
        self._mean = csr_array(_diagonal(1 / degree) @ weights)
        ones = csr_array((np.ones(len(i)), (i, j)), shape=(self.count, self.count))
        self._blur = csr_array(_diagonal(0.5 / ones.sum(axis=1)) @ ones + _diagonal(np.full(self.count, 0.5)))
        self.rest = points[j] - points[i]
        self.stretched = self.rest
        self._settled = False  # whether there are rotations to start from
        self.turns = self.stretch = np.broadcast_to(np.eye(3), (self.count, 3, 3))

    def factorised(self, weights: np.ndarray, stiffness: float) -> Callable[[np.ndarray], np.ndarray]:
        """The solver that `turn` takes, for weights (n,) of the goals and a stiffness at unit area."""
        matrix = csc_array(stiffness * self._laplacian + _diagonal(weights))
        options = {"SymmetricMode": True}
        return splu(matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=options).solve

    def turn(self, solve: Callable, goals: np.ndarray, weights: np.ndarray, stiffness: float, start: np.ndarray):
        """(n, 3) positions: least Σ weights ‖y − goals‖² + 2 stiffness · energy, with the rotations of `start`.

        Args:
            solve: of `factorised`, with the same weights and stiffness.
            goals, start: (n, 3).
            weights: (n,).
            stiffness: at unit area.
        """
        self.turns = self._rotations(start)
        turned = np.einsum("eab,ea->eb", self._between(self.turns), self.stretched) * self.w[:, None]
        return solve(weights[:, None] * goals + stiffness * self._sums(self.j, turned))

    def fit(self, goals: np.ndarray, weights: np.ndarray, stiffness: float, start: np.ndarray) -> np.ndarray:
        """(n, 3) positions after three turns; arguments as of `turn`."""
        solve, positions = self.factorised(weights, stiffness), start
        for _ in range(TURNS):
            positions = self.turn(solve, goals, weights, stiffness, positions)
        return positions

    def settle(self, positions: np.ndarray) -> None:
        """Start from positions (n, 3): their rotations, and their stretch learnt."""
        self.turns = self._rotations(positions)
        self.learn(positions)

    def learn(self, positions: np.ndarray) -> None:
        """Take the smooth part of the stretch that these positions (n, 3) show for the shape's own."""
        now = positions[self.j] - positions[self.i]
        pulled = np.einsum("eb,eab->ea", now, self.turns[self.i])
        seen = self._blurred(self._products(self.rest, pulled))
        plain = self._blurred(self._products(self.rest, self.rest))
        anyway = PLASTIC / 3 * np.trace(plain, axis1=1, axis2=2)[:, None, None] * np.eye(3)
        U = np.linalg.solve(plain + anyway, seen + anyway)
        self.stretch = (U + U.transpose(0, 2, 1)) / 2
        self.stretched = np.einsum("ea,eab->eb", self.rest, self._between(self.stretch))

    def energy(self, positions: np.ndarray) -> float:
        """What bending and stretching the undeformed shape so costs, at unit area: about the mean square strain."""
        now = positions[self.j] - positions[self.i]
        off = now - np.einsum("eab,ea->eb", self._between(self.turns), self.rest)
        return float((self.w * (off**2).sum(axis=1)).sum() / 2)

    def _rotations(self, positions: np.ndarray) -> np.ndarray:
        """(n, 3, 3) R with x R ≈ y for the edges around each vertex and around its neighbours."""
        covariances = self._products(self.stretched, positions[self.j] - positions[self.i])
        flat = covariances.reshape(self.count, 9)
        covariances = (flat + self._mean @ flat).reshape(-1, 3, 3)
        if self._settled:
            return _nearer(self.turns, covariances)
        self._settled = True
        return nearest_rotation(covariances)

    def _between(self, matrices: np.ndarray) -> np.ndarray:
        """(E, 3, 3) of the edges, from those of their ends."""
        return (matrices[self.i] + matrices[self.j]) / 2

    def _products(self, a: np.ndarray, b: np.ndarray) -> np.ndarray:
        """(n, 3, 3) Σ w a bᵀ over the edges at each vertex."""
        weighted = self.w[:, None] * a
        products = [self._sum(self.i, weighted[:, p] * b[:, q]) for p in range(3) for q in range(3)]
        return np.stack(products, axis=1).reshape(-1, 3, 3)

    def _sums(self, where: np.ndarray, vectors: np.ndarray) -> np.ndarray:
        return np.stack([self._sum(where, column) for column in vectors.T], axis=1)

    def _sum(self, where: np.ndarray, values: np.ndarray) -> np.ndarray:
        return np.bincount(where, values, minlength=self.count)

    def _blurred(self, matrices: np.ndarray) -> np.ndarray:
        flat = matrices.reshape(self.count, 9)
        for _ in range(self.blur):
            flat = self._blur @ flat
        return flat.reshape(-1, 3, 3)


def _nearer(turns: np.ndarray, covariances: np.ndarray) -> np.ndarray:
    """(n, 3, 3) rotations R, a step of Newton's from `turns` towards the largest Σ R ∘ covariances.

    Three times as fast as singular values, and as good where a turn follows a turn.
    """
    B = np.einsum("nik,nil->nkl", turns, covariances)
    pull = np.stack([B[:, 1, 2] - B[:, 2, 1], B[:, 2, 0] - B[:, 0, 2], B[:, 0, 1] - B[:, 1, 0]], axis=1)
    trace = np.trace(B, axis1=1, axis2=2)
    H = -(B + B.transpose(0, 2, 1)) / 2
    bound = np.abs(B).sum(axis=(1, 2)) + np.finfo(float).tiny
    H[:, [0, 1, 2], [0, 1, 2]] += np.maximum(trace, 0.01 * bound)[:, None]
    a, b, c, d, e, f = H[:, 0, 0], H[:, 0, 1], H[:, 0, 2], H[:, 1, 1], H[:, 1, 2], H[:, 2, 2]
    first, second, third = d * f - e * e, c * e - b * f, b * e - c * d
    determinant = a * first + b * second + c * third
    x, y, z = pull.T
    step = np.stack([
        first * x + second * y + third * z,
        second * x + (a * f - c * c) * y + (b * c - a * e) * z,
        third * x + (b * c - a * e) * y + (a * d - b * b) * z,
    ], axis=1)  # fmt: skip
    safe = determinant > 1e-6 * bound**3  # else the matrix says nothing of one direction, or the start is far off
    step = np.where(safe[:, None], step / np.where(safe, determinant, 1)[:, None], pull / bound[:, None])
    length = np.linalg.norm(step, axis=1, keepdims=True)
    p, q, r = (step / 2 / np.maximum(1, length)).T
    # The rotation of the quaternion (1, step / 2), applied to row vectors.
    scale = 1 + p * p + q * q + r * r
    Q = np.stack([
        1 + p * p - q * q - r * r, 2 * (p * q + r), 2 * (p * r - q),
        2 * (p * q - r), 1 - p * p + q * q - r * r, 2 * (q * r + p),
        2 * (p * r + q), 2 * (q * r - p), 1 - p * p - q * q + r * r,
    ], axis=1).reshape(-1, 3, 3) / scale[:, None, None]  # fmt: skip
    return turns @ Q


def _diagonal(values: np.ndarray) -> dia_array:
    return dia_array((values[None], 0), shape=(len(values), len(values)))
