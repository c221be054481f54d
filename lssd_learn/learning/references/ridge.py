"""Ridge regression for every strength at once: what the linear references of regression and classification fit."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, cast

import numpy as np
from jaxtyping import Float, Int
from numpy.typing import ArrayLike

from lssd_learn.errors import InputError

# Multiples of the mean squared singular value of the training features: no unit, no scale.
ALPHAS: Sequence[float] = tuple(np.logspace(-10, 3, 53))
MANY = 10_000  # training shapes from which on the products of the features' columns are decomposed in their place
ROUNDING = 1e-13  # part of the largest eigenvalue of these below which there is nothing else


@dataclass(frozen=True)
class Ridge:
    """min ‖(X − X̄) B − (T − T̄)‖² + a·s̄²·‖B‖² over B, solved for every a.

    X̄, T̄ and s̄², the mean squared singular value of X − X̄, are those of the training shapes. One singular value
    decomposition serves all a; of a few hundred shapes with thousands of features it takes a fraction of a second.
    Features that are all the same predict T̄.

    Attributes:
        projected: (n, r) features of every shape in the r ≤ min(n_train, d) singular directions.
        singular: (r,) singular values of X − X̄.
        loads: (r, p) training targets in the singular directions.
        mean: (p,) T̄.
        centre: (d,) X̄, and
        axes: (r, d) the singular directions; None of one made of inner products alone.
    """

    projected: Float[np.ndarray, "n r"]
    singular: Float[np.ndarray, " r"]
    loads: Float[np.ndarray, "r p"]
    mean: Float[np.ndarray, " p"]
    centre: Float[np.ndarray, " d"] | None = None
    axes: Float[np.ndarray, "r d"] | None = None

    @classmethod
    def fit(cls, features: ArrayLike, targets: Float[np.ndarray, "n p"], train: Int[np.ndarray, " t"]) -> "Ridge":
        """Fit to some of the shapes.

        Args:
            features: (n, d), such as `operator_features` gives. Scaling them all changes nothing.
            targets: (n, p) float64.
            train: positions of the shapes to fit.

        Raises:
            InputError: features that do not fit the targets.
        """
        features = np.asarray(features, dtype=np.float64)
        if features.ndim != 2 or len(features) != len(targets):
            raise InputError(f"features must be ({len(targets)}, d), got {features.shape}")
        centre, mean = features[train].mean(0), targets[train].mean(0)
        if len(train) > max(MANY, features.shape[1]):
            return cls._of_many(features, targets - mean, mean, centre, train)
        U, s, Vt = np.linalg.svd(features[train] - centre, full_matrices=False)
        return cls((features - centre) @ Vt.T, s, U.T @ (targets[train] - mean), mean, centre, Vt)

    @classmethod
    def _of_many(
        cls, features: np.ndarray, targets: np.ndarray, mean: np.ndarray, centre: np.ndarray, train
    ) -> "Ridge":
        """The same but for rounding, in a few passes over the shapes."""
        d = features.shape[1]
        products, loads = np.zeros((d, d)), np.zeros((d, targets.shape[1]))
        for some in np.array_split(train, -(-len(train) // MANY)):
            few = features[some] - centre
            products += few.T @ few
            loads += few.T @ targets[some]
        squares, V = np.linalg.eigh(products)
        s, V = np.sqrt(np.where(squares > ROUNDING * squares[-1], squares, 0.0))[::-1], V[:, ::-1]
        loads = V.T @ loads
        loads = np.divide(loads, s[:, None], out=np.zeros_like(loads), where=s[:, None] > 0)
        return cls((features - centre) @ V, s, loads, mean, centre, V.T)

    @property
    def is_constant(self) -> bool:
        """Whether the training features tell no shape from another."""
        return not np.mean(self.singular**2) > 0

    def best(
        self, positions: Int[np.ndarray, " m"], loss: Callable[[np.ndarray], Any], alphas: Sequence[float] = ALPHAS
    ) -> float | None:
        """The a whose predictions (m, p) at these positions have the least loss, the first of equals.

        None where the features tell no shape from another: every a is as good.
        """
        return None if self.is_constant else float(min(alphas, key=lambda a: loss(self.at(positions, a))))

    def at(self, positions: Int[np.ndarray, " m"], alpha: float | None) -> Float[np.ndarray, "m p"]:
        """(m, p) predictions for the shapes at these positions, for one a."""
        return self._predicted(self.projected[positions], alpha)

    def predict(self, features: ArrayLike, alpha: float | None) -> Float[np.ndarray, "m p"]:
        """(m, p) predictions for further shapes, from their features (m, d), for one a.

        Raises:
            InputError: features of another number, a ridge made of inner products alone.
        """
        features = np.asarray(features, dtype=np.float64)
        if self.axes is None or self.centre is None:
            raise InputError("predict: expected a ridge fitted to features, this one knows inner products alone")
        if features.ndim != 2 or features.shape[1] != len(self.centre):
            raise InputError(f"features must be (m, {len(self.centre)}), got {features.shape}")
        return self._predicted((features - self.centre) @ self.axes.T, alpha)

    def _predicted(self, projected: np.ndarray, alpha: float | None) -> np.ndarray:
        s = self.singular
        if self.is_constant:
            return np.tile(self.mean, (len(projected), 1))
        shrunk = s / (s**2 + cast(float, alpha) * np.mean(s**2))
        return projected @ (shrunk[:, None] * self.loads) + self.mean
