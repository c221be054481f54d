"""From vertices to operators in PyTorch, with gradients: eigenbasis, maps, latent basis, operators.

The names are those of the rest of the package, on tensors of any device: `eigenbasis` → `functional_map` →
`latent_basis` → `latent_operators`, or `pushed_functions` → `pushed_operators` in a latent space that is given. What
other rooms find in a cache is computed every time here. First derivatives only.
"""

from lssd_learn.differentiable.eigenbasis import Basis, eigenbasis
from lssd_learn.differentiable.latent import (
    Latent,
    functional_map,
    latent_basis,
    latent_operators,
    pushed_functions,
    pushed_operators,
)
from lssd_learn.differentiable.operators import vertex_operators

__all__ = [
    "Basis",
    "Latent",
    "eigenbasis",
    "functional_map",
    "latent_basis",
    "latent_operators",
    "pushed_functions",
    "pushed_operators",
    "vertex_operators",
]
