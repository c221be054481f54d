"""A collection at a glance: its operators as points in the plane."""

from dataclasses import dataclass, replace

import numpy as np
import torch
from jaxtyping import Float
from torch import Tensor
from torch.nn import functional as F

from lssd_learn.errors import InputError, check_whole
from lssd_learn.exploration.variability import highlighted


@dataclass(frozen=True)
class Embedding:
    """Principal components of n shapes, and of others of the same latent space.

    Attributes:
        points: (n, d), one a shape.
        ratios: (d,) the part of the variance along each axis.
        mean: (p,) what the axes start from, the flattened mean of what was embedded.
        axes: (d, p) orthonormal rows; zero beyond the dimensions there are.
        alpha: (m, …) the functions that operators were applied to first; None embeds operators.
    """

    points: Float[Tensor, "n d"]
    ratios: Float[Tensor, " d"]
    mean: Float[Tensor, " p"]
    axes: Float[Tensor, "d p"]
    alpha: Tensor | None = None

    def transform(self, operators: Float[Tensor | np.ndarray, "q m m"]) -> Float[Tensor, "q d"]:
        """(q, d) the places of q further shapes, from their operators (q, m, m); of the n shapes it is `points`.

        Raises:
            InputError: operators of another size.
        """
        seen = torch.as_tensor(operators)
        if seen.shape[1:].numel() != len(self.mean) and self.alpha is None:
            raise InputError(f"operators: expected as many entries as those embedded, got {tuple(seen.shape)}")
        seen = seen if self.alpha is None else highlighted(seen, self.alpha)
        return (seen.to(self.mean).flatten(1) - self.mean) @ self.axes.T

    def __repr__(self) -> str:
        return (
            f"Embedding({len(self.points)} shapes, {', '.join(f'{r:.0%}' for r in self.ratios.tolist())} of variance)"
        )


def embed(
    operators: Float[Tensor | np.ndarray, "n m m"],
    dimensions: int = 2,
    alpha: Float[Tensor | np.ndarray, " m *p"] | None = None,
) -> Embedding:
    """Principal components of operators (n, m, m), or of D_iα for a function alpha (m,) or several (m, p)."""
    found = pca(operators if alpha is None else highlighted(operators, alpha), dimensions)
    return replace(found, alpha=None if alpha is None else torch.as_tensor(alpha))


def pca(operators: Float[Tensor | np.ndarray, "n ..."], dimensions: int = 2) -> Embedding:
    """Principal components of operators (n, …) in the Frobenius inner product.

    Each axis points to where the largest coordinate is positive. Two shapes lie on a line, and so on: further axes are
    zero.
    """
    flat = torch.as_tensor(operators).double().flatten(1)
    check_whole("dimensions", dimensions, 1)
    mean = flat.mean(0)
    U, s, Vt = torch.linalg.svd(flat - mean, full_matrices=False)
    Vt = torch.where(s[:, None] > len(flat) * torch.finfo(s.dtype).eps * s.max(), Vt, 0.0) if len(s) else Vt
    spare = max(0, dimensions - len(s))
    U, s, Vt = F.pad(U, (0, spare)), F.pad(s, (0, spare)), F.pad(Vt, (0, 0, 0, spare))
    points, axes = (U * s)[:, :dimensions], Vt[:dimensions]
    extreme = points.gather(0, points.abs().argmax(0, keepdim=True))
    signs = torch.where(extreme < 0, -1.0, 1.0)
    ratios = (s**2 / (s**2).sum().clamp(min=torch.finfo(s.dtype).tiny))[:dimensions]
    return Embedding(points * signs, ratios, mean, axes * signs.T)
