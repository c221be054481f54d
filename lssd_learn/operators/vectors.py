"""Operators as vectors with the inner products of the matrices: what kernels, baselines and references read.

Positive definite matrices are compared by the difference of their logarithms (log-Euclidean geometry: Arsigny,
Fillard, Pennec & Ayache 2006): what two shapes do to areas one after the other then adds up, nearly.
"""

from collections.abc import Sequence

import torch
from jaxtyping import Bool, Float
from torch import Tensor

from lssd_learn.errors import InputError
from lssd_learn.operators.matrices import SMALLEST, WRONG, as_operators, null_functions, restrict, symmetric_eigh


def entries(D: Float[Tensor, "*s m m"]) -> Float[Tensor, "*s d"]:
    """(…, m (m + 1) / 2) of symmetric matrices (…, m, m): the upper triangle, times √2 off the diagonal."""
    rows, columns = torch.triu_indices(*D.shape[-2:])
    return D[..., rows, columns] * torch.where(rows == columns, 1.0, 2**0.5).to(D)


def log_vectors(D) -> Float[Tensor, "n d"]:
    """Logarithms of symmetric positive definite matrices, as `entries`.

    Operators kept in float32 may have an eigenvalue that is nothing but rounding: it counts as `SMALLEST` of the
    largest. `logarithm` refuses them; a net has to go on.

    Args:
        D: (n, m, m).

    Returns:
        (n, m (m + 1) / 2) float64.

    Raises:
        InputError: a matrix that is not symmetric or not positive.
    """
    evals, V = symmetric_eigh("operators", as_operators("operators", D))
    largest = evals[..., -1:]
    if not _are_positive(evals):
        raise InputError("operators: expected positive definite ones, of which logarithms can be taken")
    return entries((V * evals.maximum(SMALLEST * largest).log()[..., None, :]) @ V.mT)


def _are_positive(evals: Tensor) -> bool:
    """Whether ascending eigenvalues (…, m) are those of positive matrices, but for rounding."""
    largest = evals[..., -1:]
    return not ((evals < -WRONG * largest).any() or (largest <= 0).any())


def live_functions(operators: Float[Tensor, "n channels m m"]) -> Bool[Tensor, "channels m"]:
    """(channels, m) bool: which functions are not null in operators (n, channels, m, m), see `null_functions`."""
    return torch.stack([~null_functions(operators[:, c]) for c in range(operators.shape[1])])


def log_features(operators: Float[Tensor, "n channels m m"], live: Bool[Tensor, "channels m"]) -> Float[Tensor, "n d"]:
    """(n, d) float64 logarithms of operators (n, channels, m, m), each channel on its live functions (channels, m)."""
    return torch.cat([log_vectors(restrict(operators[:, c], some)) for c, some in enumerate(live)], dim=1)


def shape_variables(operators: Float[Tensor, "n channels m m"], kinds: Sequence[str]) -> dict[str, Float[Tensor, " n"]]:
    """Logarithms of operators as the columns of a table n × p, for programs of statistics.

    The column area_2_5 is the entry (2, 5) of log D of the area operators, times √2 off the diagonal: distances of rows
    are those of the logarithms. Latent functions are counted from 1; null ones have no columns, and kinds of operators
    that are not all positive none either.

    Args:
        operators: (n, channels, m, m).
        kinds: names of the channels.
    """
    columns: dict[str, Tensor] = {}
    for c, kind in enumerate(kinds):
        live = ~null_functions(operators[:, c])
        D = restrict(operators[:, c], live)
        if not _are_positive(symmetric_eigh("operators", as_operators("operators", D))[0]):
            continue
        number = (live.nonzero()[:, 0] + 1).tolist()
        places = torch.triu_indices(len(number), len(number)).T.tolist()
        names = [f"{kind}_{number[i]}_{number[j]}" for i, j in places]
        columns |= dict(zip(names, log_vectors(D).T, strict=True))
    return columns
