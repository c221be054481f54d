"""Where groups differ, as a field on the shapes, and whether it stays there when a shape is left out.

One function shows a part of it: the left and the right of a symmetric shape tell groups apart equally well, a region
that grew has overtones as a drum has, and which mixture comes first is chance. All functions by their shares know no
mixtures. Asked at every vertex of the function that is most concentrated there, they give a size as well: of area
operators the part by which areas differ.
"""

from collections.abc import Sequence

import numpy as np
import torch
from jaxtyping import Bool, Float
from torch import Tensor

from lssd_learn.exploration.blocks import block_codes
from lssd_learn.exploration.pairs import as_stack, group_codes, pair_energies
from lssd_learn.exploration.scores import correlation
from lssd_learn.exploration.variability import contrast, cross_collection
from lssd_learn.latent import LatentSpace
from lssd_learn.progress import track


def evidence(
    D, labels: Sequence, count: int | None = None, method: str = "difference", mean: bool = True, epsilon: float = 1e-2
) -> Float[Tensor, "m count"]:
    """R (m, count): the functions of `cross_collection`, each as long as it has a share in what tells groups apart.

    Column j is √μ_j α_j with μ = αᵀ(across − within)α, 0 where that is negative. RRᵀ knows no signs, and where two
    functions have equal shares, not which mixtures of the two they are; of all functions by "difference" it is the
    positive part of across − within. To be looked at as `local_evidence`.

    Args:
        count: how many functions; None is all.
        D, labels, method, mean, epsilon: as `cross_collection`.

    Raises:
        InputError: as `cross_collection`.
    """
    D = as_stack("D", D)
    alpha = cross_collection(D, labels, D.shape[-1] if count is None else count, method, mean, epsilon)
    return _weighted(alpha, pair_energies(D, labels, mean))


def local_evidence(latent: LatentSpace, R: Float[Tensor, "m count"], i: int) -> Float[Tensor, " V"]:
    """How much groups differ at each vertex of shape i: (V,) ‖Rᵀφ‖ / ‖φ‖, φ (m,) the row of Φ_iY_i at the vertex.

    φ / ‖φ‖ is the function of unit length, among those of the latent space, that is most concentrated at the vertex; by
    it, pairs across groups are so much farther apart than pairs within (root mean square). Of area operators, with R of
    all functions: about the part of the area by which groups differ there, as smooth as m functions are.

    Args:
        latent: with its eigenbases.
        R: (m, count) of `evidence`.
        i: the shape.
    """
    return (concentrated(latent, i) @ torch.as_tensor(R).to(latent.Y)).norm(dim=1)


def concentrated(latent: LatentSpace, i: int, live: Bool[Tensor, " m"] | None = None) -> Float[Tensor, "V _"]:
    """(V, m): a row a vertex of shape i, the function of unit length that is most concentrated there.

    Args:
        latent: with its eigenbases.
        i: the shape.
        live: (m,) bool, functions to take it from; None is all.
    """
    functions = torch.eye(latent.keep).to(latent.Y)
    rows = latent.to_shape(functions if live is None else functions[:, live], i)
    return rows / rows.norm(dim=1, keepdim=True).clamp(min=torch.finfo(rows.dtype).tiny)


def evidence_stability(
    latent: LatentSpace,
    D,
    labels: Sequence,
    count: int | None = None,
    method: str = "difference",
    mean: bool = True,
    epsilon: float = 1e-2,
    blocks: Sequence | None = None,
) -> Float[Tensor, " l"]:
    """How like the field of `local_evidence` is, on each shape that has a label, to the one found without that label.

    With blocks it is found without the labels of the whole block. Of shape i it is the correlation of the squares of
    the two fields over the area of shape i. The latent space is that of all shapes throughout.

    Args:
        latent: n shapes, with their eigenbases.
        D: (n, m, m) operators.
        labels: n of them; None, "" or nan is a shape that plays no part.
        count, method, mean, epsilon: as `evidence`.
        blocks: n labels of what belongs together, None where nothing does; a shape without one stands alone.

    Returns:
        (l,) correlations of the l shapes with a label, in their order; 1 is the same field.

    Raises:
        InputError: as `cross_collection`, for any of the shapes left out.
    """
    D = as_stack("D", D)
    codes, _ = group_codes(labels, len(D))
    whole = evidence(D, labels, count, method, mean, epsilon)
    of = np.arange(len(D)) if blocks is None else block_codes(blocks, len(D))
    known = (codes >= 0).numpy()
    found = np.empty(len(D))
    for block in track(np.unique(of[known]).tolist(), f"leaving each {'shape' if blocks is None else 'block'} out"):
        out = of == block
        left = [None if gone or c < 0 else c for gone, c in zip(out, codes.tolist(), strict=True)]
        energies = pair_energies(D, left, mean)
        without = _weighted(contrast(energies, method, epsilon)[:, :count], energies)
        for i in np.flatnonzero(out & known).tolist():
            at = concentrated(latent, i)
            field, again = ((at @ R.to(at)).square().sum(1).cpu().numpy() for R in (whole, without))
            found[i] = correlation(field, again, latent.eigenbasis(i).mass)
    return torch.from_numpy(found[known])


def _weighted(alpha: Tensor, energies) -> Tensor:
    shares = torch.einsum("aj,ab,bj->j", alpha, energies.across - energies.within, alpha).clamp(min=0)
    return alpha * shares.sqrt()
