"""Operators of vertices, differentiable: for meshes of one connectivity and functions that stay where they are.

The latent functions have values B (V, m) at the vertices. Where vertices move and B does not, masses and cotangents
follow, and the operators with them: D^A = BᵀMB, the others likewise. At the vertices of shape i with B = Φ_iY_i these
are its own operators; of other shapes they are what vertex identity gives when nothing is truncated. No eigenproblem is
solved, so no gauge is chosen and nothing breaks at multiple eigenvalues.
"""

from collections.abc import Sequence

import torch
from jaxtyping import Float, Int
from torch import Tensor

from lssd_learn.differentiable.forms import dirichlet_form, vertex_masses
from lssd_learn.errors import InputError
from lssd_learn.latent.differences import Seen, check_kinds, pieces, pseudo_inverse
from lssd_learn.latent.extrinsic import latent_root
from lssd_learn.shapes.moments import pair_form

KINDS = ("area", "conformal", "extrinsic")


def vertex_operators(
    vertices: Float[Tensor, "V 3"],
    faces: Int[Tensor, "F 3"],
    functions: Float[Tensor, "V m"],
    seen: Seen,
    kinds: Sequence[str] = KINDS,
) -> Float[Tensor, "channels m m"]:
    """(channels, m, m) symmetric operators of a mesh, as `stack_differences` has them, with gradients to `vertices`.

    Args:
        vertices: (V, 3), on any device.
        faces: (F, 3).
        functions: B (V, m), values of the latent functions at the vertices: `space.to_shape(torch.eye(m), i)`.
        seen: of the latent space, whose frequencies and average form the operators are relative to.
        kinds: some of area, conformal, extrinsic.

    Raises:
        InputError: a difference of another kind; what `reference` raises.
    """
    check_differentiable(kinds)
    B = functions.to(vertices)
    mass = vertex_masses(vertices, faces)
    found = []
    for kind in kinds:
        if kind == "area":
            found.append(B.mT @ (mass[:, None] * B))
        elif kind == "conformal":
            root = conformal_root(seen).to(B)
            found.append(root[:, None] * dirichlet_form(vertices, faces, B) * root)
        else:
            root = latent_root(seen).to(B)
            found.append(root @ pair_form(vertices, mass, B)[0] @ root)
    return torch.stack(found)


def check_differentiable(kinds: Sequence[str]) -> None:
    """Refuse differences without gradients.

    Raises:
        InputError: one of another kind than `KINDS`.
    """
    check_kinds(kinds)
    if others := [kind for kind in kinds if kind not in KINDS]:
        raise InputError(f"{others[0]}: expected some of {', '.join(KINDS)}; others are not differentiable here")


def conformal_root(seen) -> Float[Tensor, " m"]:
    """The diagonal (m,) of Λ₀^-½ of a space, as conformal differences have it: zero at null functions."""
    return pseudo_inverse(seen.spectrum, pieces(seen.evals)).sqrt()
