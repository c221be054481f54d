"""The latent basis of a shape that was not there when the space was fitted."""

from collections.abc import Sequence
from typing import cast

import torch
from jaxtyping import Float
from torch import Tensor


def push_nearest(Y: Float[Tensor, "k m"], to_new: Float[Tensor, "k_new k"]) -> Float[Tensor, "k_new m"]:
    """Y_new = C Y (k_new, m), through the map C (k_new, k) from one shape with basis Y (k, m): the paper's way.

    What the map loses is lost: the operators come out too small at high frequencies. `push_least_squares` repairs it.
    """
    return to_new @ Y


def push_least_squares(
    Ys: Sequence[Float[Tensor, "_ m"]],
    to_new: Sequence[Float[Tensor, "k_new _"]],
    from_new: Sequence[Float[Tensor, "_ k_new"]],
) -> Float[Tensor, "k_new m"]:
    """The basis (k_new, m) that agrees best with p neighbours in both directions.

    Minimises Σ_i ‖C_i→new Y_i − Y‖² + ‖C_new→i Y − Y_i‖²:  (Σ C_new→iᵀ C_new→i + p I) Y = Σ (C_i→new + C_new→iᵀ) Y_i.

    Args:
        Ys: p canonical bases (k_i, m).
        to_new: p maps (k_new, k_i).
        from_new: p maps (k_i, k_new).
    """
    left = cast(Tensor, sum(C.T @ C for C in from_new))
    left = left + len(Ys) * torch.eye(len(left)).to(left)
    right = sum((there + back.T) @ Y for Y, there, back in zip(Ys, to_new, from_new, strict=True))
    return torch.linalg.solve(left, cast(Tensor, right))
