"""A collection at a glance: its operators as points in the plane."""

from dataclasses import dataclass

import torch
from torch import Tensor

from lssd_learn.errors import InputError


@dataclass(frozen=True)
class Embedding:
    """`points` (n, d), one a shape, and `ratios` (d,), the part of the variance along each axis."""

    points: Tensor
    ratios: Tensor


def pca(operators: Tensor, dimensions: int = 2) -> Embedding:
    """Principal components of operators (n, …) in the Frobenius inner product.

    Each axis points to where the largest coordinate is positive.
    """
    flat = torch.as_tensor(operators).double().flatten(1)
    if not 1 <= dimensions < len(flat):
        raise InputError(f"dimensions={dimensions}: expected 1 to {len(flat) - 1} for {len(flat)} shapes")
    U, s, _ = torch.linalg.svd(flat - flat.mean(0), full_matrices=False)
    points = (U * s)[:, :dimensions]
    extreme = points.gather(0, points.abs().argmax(0, keepdim=True))
    points = points * torch.where(extreme < 0, -1.0, 1.0)
    return Embedding(points, (s**2 / (s**2).sum().clamp(min=torch.finfo(s.dtype).tiny))[:dimensions])
