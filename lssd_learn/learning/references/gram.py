"""Ridge regression from inner products alone: for features far more numerous than shapes, in the room of n × n."""

import numpy as np
from jaxtyping import Float, Int

from lssd_learn.learning.references.ridge import Ridge

BLOCK = 4096  # features that are in float64 at a time
# Of the centred training shapes one direction at least is nothing; so far below the largest is rounding.
NEGLIGIBLE = 1e-13


def gram(features: Float[np.ndarray, "n d"], train: Int[np.ndarray, " t"]) -> Float[np.ndarray, "n n"]:
    """Inner products (n, n) float64 of features (n, d), centred on the mean of the shapes `train`.

    Whatever the features' precision, they are subtracted, multiplied and summed in float64, some of them at a time.
    The products of several kinds of features side by side are the sum of those of each kind.
    """
    products = np.zeros((len(features), len(features)))
    for start in range(0, features.shape[1], BLOCK):
        some = features[:, start : start + BLOCK].astype(np.float64)
        some -= some[train].mean(axis=0)
        products += some @ some.T
    return products


def ridge_of_gram(
    products: Float[np.ndarray, "n n"], targets: Float[np.ndarray, "n p"], train: Int[np.ndarray, " t"]
) -> Ridge:
    """The ridge regression that `Ridge.fit` makes of the features themselves, if there are as many as training shapes.

    Fewer give the same predictions for other strengths: s̄² is the mean over as many directions as training shapes.

    Args:
        products: (n, n) of `gram`, with the same `train`.
        targets: (n, p) float64.
        train: positions of the shapes to fit.
    """
    mean = targets[train].mean(axis=0)
    squares, U = np.linalg.eigh(products[np.ix_(train, train)])
    live = squares > NEGLIGIBLE * max(squares[-1], 0.0)
    singular = np.sqrt(np.where(live, squares, 0.0))
    inverse = np.divide(1.0, singular, out=np.zeros_like(singular), where=live)
    return Ridge(products[:, train] @ (U * inverse), singular, U.T @ (targets[train] - mean), mean)
