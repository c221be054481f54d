"""A region of the shapes as functions on the latent shape: what operators are localised with."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import torch
from jaxtyping import Float
from torch import Tensor

from lssd_learn.errors import InputError
from lssd_learn.progress import track


@dataclass(frozen=True)
class Region:
    """A region seen from the latent shape.

    Attributes:
        operator: R̂ (m, m) symmetric, restriction to the region: of everything it is the identity.
        shares: (m,) its eigenvalues, descending, in [0, 1]: the part of each function that lives on the region.
        functions: F (m, r) orthonormal, the eigenvectors whose share is above the threshold. Only their span matters.
    """

    operator: Float[Tensor, "m m"]
    shares: Float[Tensor, " m"]
    functions: Float[Tensor, "m r"]

    def __repr__(self) -> str:
        return f"Region({self.functions.shape[1]} of {len(self.shares)} functions)"


def find_region(latent, masks, threshold: float = 0.5) -> Region:
    """R̂ = (1/n) Σ Y_iᵀΦ_iᵀM_i 1_{R_i} Φ_iY_i of a region R_i on each of n shapes.

    With the threshold ½ the functions of a region and those of its complement are each other's orthogonal complement.

    Args:
        latent: a fitted space with its eigenbases. (In one of pushed shapes alone, where the mean of YᵀY is not the
            identity, shares may exceed 1.)
        masks: (V,) bool, for shapes in vertex correspondence, or a sequence of n, one (V_i,) a shape.
        threshold: in [0, 1).

    Raises:
        InputError: masks that do not fit the shapes, a threshold out of range, a space without its eigenbases.
    """
    if not 0 <= threshold < 1:
        raise InputError(f"threshold={threshold}: expected a part of 1, 0 or more and below 1")
    masks = _one_a_shape(masks, len(latent))
    R = torch.zeros(latent.keep, latent.keep).to(latent.Y)
    for i, mask in enumerate(track(masks, "region")):
        basis = latent.eigenbasis(i)
        mask = _mask(mask, i, len(basis.mass))
        Phi, M = np.asarray(basis.evecs)[mask].astype(float), np.asarray(basis.mass)[mask]
        R += latent.Y[i].T @ torch.as_tensor(Phi.T @ (M[:, None] * Phi)).to(R) @ latent.Y[i] / len(latent)
    shares, V = torch.linalg.eigh((R + R.T) / 2)
    shares, V = shares.flip(0), V.flip(1)
    return Region(R, shares, V[:, shares > threshold])


def _one_a_shape(masks, n: int) -> Sequence:
    if len(masks) and np.ndim(masks[0]) == 0:
        return [masks] * n
    if len(masks) != n:
        raise InputError(f"masks: expected one for all shapes or one for each of {n}, got {len(masks)}")
    return masks


def _mask(mask, i: int, vertices: int) -> np.ndarray:
    mask = np.asarray(mask)
    if mask.dtype != bool or mask.shape != (vertices,):
        raise InputError(
            f"masks: expected a bool for each of the {vertices:,} vertices of shape {i}, got {mask.dtype} {mask.shape}"
        )
    return mask
