"""A collection at a glance: its operators as points in the plane."""

from dataclasses import dataclass

import torch
from torch import Tensor
from torch.nn import functional as F

from lssd_learn.errors import check_whole
from lssd_learn.exploration.variability import highlighted


@dataclass(frozen=True)
class Embedding:
    """`points` (n, d), one a shape, and `ratios` (d,), the part of the variance along each axis."""

    points: Tensor
    ratios: Tensor


def embed(operators: Tensor, dimensions: int = 2, alpha: Tensor | None = None) -> Embedding:
    """Principal components of operators (n, m, m), or of D_iα for a function alpha (m,) or several (m, p)."""
    return pca(operators if alpha is None else highlighted(operators, alpha), dimensions)


def pca(operators: Tensor, dimensions: int = 2) -> Embedding:
    """Principal components of operators (n, …) in the Frobenius inner product.

    Each axis points to where the largest coordinate is positive. Two shapes lie on a line, and so on: further axes are
    zero.
    """
    flat = torch.as_tensor(operators).double().flatten(1)
    check_whole("dimensions", dimensions, 1)
    U, s, _ = torch.linalg.svd(flat - flat.mean(0), full_matrices=False)
    spare = max(0, dimensions - len(s))
    U, s = F.pad(U, (0, spare)), F.pad(s, (0, spare))
    points = (U * s)[:, :dimensions]
    extreme = points.gather(0, points.abs().argmax(0, keepdim=True))
    points = points * torch.where(extreme < 0, -1.0, 1.0)
    return Embedding(points, (s**2 / (s**2).sum().clamp(min=torch.finfo(s.dtype).tiny))[:dimensions])
