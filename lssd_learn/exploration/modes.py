"""From operators to shapes in correspondence by a small kernel map, that a page can evaluate while a finger moves.

Operators become coordinates: principal components of their logarithms. Vertices become coefficients of the principal
modes of the shapes. Between them ridge regression: f(c) = Σ_i a_i k(c, c_i), k(c, c') = c·c' + w exp(−‖c − c'‖² / 2h²).
"""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float
from torch import Tensor

from lssd_learn.errors import InputError
from lssd_learn.exploration.embed import pca

# What is chosen from: widths h of the Gaussian, its weights w, ridges. Coordinates have a mean square norm of one.
WIDTHS, WEIGHTS, RIDGES = (0.5, 1.0, 2.0), (0.0, 0.3, 1.0, 3.0), tuple(10.0**e for e in range(-6, 1))
HELD = 5  # every fifth shape, in a random order, tells how good the map is
LEAST = 10  # shapes for that
NEGLIGIBLE = 1e-10  # of the largest variance: modes of less are rounding


@dataclass(frozen=True, eq=False)
class ShapeMap:
    """Coordinates of operators, modes of vertices and the map between them.

    Attributes:
        coordinates: (n, d) of the shapes, mean zero.
        mean: (V, 3).
        modes: (r, V, 3) orthonormal.
        linear: (d, r) the linear part of the map: coefficients are c @ linear + Σ_i k_i dual_i.
        dual: (n, r) of the Gaussian part, zero where the linear one serves.
        width: h.
        error: mean vertex error of shapes that were left out, in the unit of length; NaN of fewer than ten.
        spread: mean vertex distance of those from the mean of the others.
    """

    coordinates: Float[np.ndarray, "n d"]
    mean: Float[np.ndarray, "V 3"]
    modes: Float[np.ndarray, "r V 3"]
    linear: Float[np.ndarray, "d r"]
    dual: Float[np.ndarray, "n r"]
    width: float
    error: float = float("nan")
    spread: float = float("nan")

    def coefficients(self, c: Float[np.ndarray, "s d"]) -> Float[np.ndarray, "s r"]:
        """f(c), so much of each mode."""
        return c @ self.linear + _gaussian(c, self.coordinates, self.width) @ self.dual

    def vertices(self, c: Float[np.ndarray, "s d"]) -> Float[np.ndarray, "s V 3"]:
        """The shapes of coordinates."""
        return self.mean + np.tensordot(self.coefficients(c), self.modes, 1)


def shape_map(
    features: Float[Tensor, "n p"],
    vertices: Float[np.ndarray, "n V 3"],
    dimensions: int = 30,
    modes: int = 40,
    seed: int = 0,
) -> ShapeMap:
    """The map from n shapes, its width, weight and ridge chosen by leaving out one shape after the other.

    How good it is, every fifth shape tells that had no part in it; then it is made of all.

    Args:
        features: of the operators, see `log_features`.
        vertices: of the same shapes, laid upon each other.
        dimensions, modes: at most so many coordinates and modes.
        seed: of which shapes are left out.

    Raises:
        InputError: fewer than three shapes, or nothing in which they differ.
    """
    n = len(vertices)
    if n < 3:
        raise InputError(f"shapes: expected three or more to move between, got {n}")
    c = np.asarray(pca(features, min(dimensions, n - 1)).points, dtype=float)
    c = c / np.sqrt(np.mean(np.sum(c**2, axis=1)) or 1.0)
    found = _fit(c, vertices, modes)
    if n < LEAST:
        return found
    held = np.zeros(n, dtype=bool)
    held[np.random.default_rng(seed).permutation(n)[::HELD]] = True
    tried = _fit(c[~held], vertices[~held], modes)
    error, spread = (
        float(np.mean([np.linalg.norm(x - y, axis=1).mean() for x, y in zip(drawn, vertices[held], strict=True)]))
        for drawn in (tried.vertices(c[held]), [tried.mean] * int(held.sum()))
    )
    return replace(found, error=error, spread=spread)


def _fit(c: np.ndarray, vertices: np.ndarray, most: int) -> ShapeMap:
    mean = vertices.mean(axis=0, dtype=np.float64)
    if not np.ptp(vertices, axis=0).any():
        raise InputError("shapes: expected some that differ, these are all the same")
    flat = (vertices - mean).reshape(len(vertices), -1)
    evals, U = np.linalg.eigh(flat @ flat.T)  # n × n: modes are combinations of the shapes
    order = np.argsort(-evals)
    kept = order[evals[order] > NEGLIGIBLE * evals[order[0]]][:most]
    sizes = np.sqrt(evals[kept])
    modes, Y = (U[:, kept] / sizes).T @ flat, U[:, kept] * sizes
    best = None
    for width in WIDTHS:
        gaussian = _gaussian(c, c, width)
        for weight in WEIGHTS:
            K, V = np.linalg.eigh(c @ c.T + weight * gaussian)
            for ridge in RIDGES:
                inverse = (V / (np.maximum(K, 0) + ridge)) @ V.T
                dual = inverse @ Y
                left_out = np.sum((dual / inverse.diagonal()[:, None]) ** 2)
                if best is None or left_out < best[0]:
                    best = left_out, width, weight, dual
    assert best is not None
    _, width, weight, dual = best
    return ShapeMap(c, mean, modes.reshape(-1, *mean.shape), c.T @ dual, weight * dual, width)


def _gaussian(c: np.ndarray, others: np.ndarray, width: float) -> np.ndarray:
    squares = ((c[:, None] - others) ** 2).sum(-1)
    return np.exp(-squares / (2 * width**2))
