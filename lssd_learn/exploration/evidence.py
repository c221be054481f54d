"""Where groups differ, as a field on the shapes, and whether it stays there when a shape is left out.

The best function alone may show half of it: the left and the right of a symmetric shape tell groups apart equally well,
and which side, or which mixture, comes first is chance. The first few functions together say where.
"""

from collections.abc import Sequence

import numpy as np
import torch
from torch import Tensor

from lssd_learn.exploration.pairs import as_collection, group_codes, pair_energies
from lssd_learn.exploration.variability import SMALLEST, contrast, cross_collection
from lssd_learn.latent import LatentSpace
from lssd_learn.progress import track


def evidence(
    D, groups: Sequence, count: int = 1, method: str = "difference", mean: bool = True, epsilon: float = 1e-2
) -> Tensor:
    """R (m, count): the functions of `cross_collection`, each as long as it has a share in what tells groups apart.

    Column j is √w_j α_j with w_j = μ_j / max μ and μ = αᵀ(across − within)α, 0 where that is negative. On a shape,
    the sum of squares Σ_j w_j (Φ_iY_iα_j)² is the field to look at: it knows no signs, and where two functions have
    equal shares, not which mixtures of the two they are.

    Arguments and errors as `cross_collection`.
    """
    alpha = cross_collection(D, groups, count, method, mean, epsilon)
    return _weighted(alpha, pair_energies(D, groups, mean))


def evidence_stability(
    latent: LatentSpace,
    D,
    groups: Sequence,
    count: int = 1,
    method: str = "difference",
    mean: bool = True,
    epsilon: float = 1e-2,
) -> Tensor:
    """How like the field of `evidence` is, on each shape that has a label, to the one found without that label.

    Of shape i it is the correlation of the two fields over the area of shape i. The latent space is that of all shapes
    throughout.

    Args:
        latent: n shapes, with their eigenbases.
        D: (n, m, m) operators.
        groups: n labels; None, "" or nan is a shape that plays no part.
        count, method, mean, epsilon: as `evidence`.

    Returns:
        (l,) correlations of the l shapes with a label, in their order; 1 is the same field.

    Raises:
        InputError: as `cross_collection`, for any of the shapes left out.
    """
    D = as_collection("D", D)
    codes, _ = group_codes(groups, len(D))
    whole = evidence(D, groups, count, method, mean, epsilon)
    found = []
    for i in track((codes >= 0).nonzero().flatten().tolist(), "leaving each shape out"):
        energies = pair_energies(D, [None if j == i or c < 0 else c for j, c in enumerate(codes.tolist())], mean)
        without = _weighted(contrast(energies, method, epsilon)[:, :count], energies)
        fields = latent.to_shape(torch.cat([whole, without], dim=1), i).square().unflatten(1, (2, count)).sum(2)
        found.append(_correlation(fields.cpu().numpy(), np.asarray(latent.bases[i].mass)))
    return torch.tensor(found, dtype=torch.float64)


def _weighted(alpha: Tensor, energies) -> Tensor:
    shares = torch.einsum("aj,ab,bj->j", alpha, energies.across - energies.within, alpha).clamp(min=0)
    return alpha * (shares / shares.max().clamp(min=SMALLEST)).sqrt()


def _correlation(fields: np.ndarray, mass: np.ndarray) -> float:
    """Of two fields (V, 2) over a surface of vertex areas mass (V,); 0 where one is the same everywhere."""
    a, b = (fields - mass @ fields / mass.sum()).T
    return float(mass @ (a * b) / max(np.sqrt((mass @ a**2) * (mass @ b**2)), np.finfo(float).tiny))
