"""The nearest matrix that only turns, of latent bases as of frames."""

import torch
from jaxtyping import Float
from torch import Tensor


def nearest_orthogonal(matrix: Float[Tensor, "*sets m m"]) -> Float[Tensor, "*sets m m"]:
    """The orthogonal matrix Q nearest to (…, m, m) matrices.

    Of matrix = Σ AᵢᵀBᵢ it is the one that minimises Σ ‖Aᵢ Q − Bᵢ‖² (Schönemann 1966).
    """
    U, _, Vt = torch.linalg.svd(matrix)
    return U @ Vt
