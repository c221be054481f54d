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
    check_kinds(kinds)
    if others := [kind for kind in kinds if kind not in KINDS]:
        raise InputError(f"{others[0]}: expected some of {', '.join(KINDS)}; others are not differentiable here")
    B = functions.to(vertices)
    mass = vertex_masses(vertices, faces)
    found = []
    for kind in kinds:
        if kind == "area":
            found.append(B.mT @ (mass[:, None] * B))
        elif kind == "conformal":
            root = pseudo_inverse(seen.spectrum, pieces(seen.evals)).sqrt().to(B)
            found.append(root[:, None] * dirichlet_form(vertices, faces, B) * root)
        else:
            root = latent_root(seen).to(B)
            found.append(root @ pair_form(vertices, mass, B)[0] @ root)
    return torch.stack(found)


def vertex_masses(vertices: Float[Tensor, "V 3"], faces: Int[Tensor, "F 3"]) -> Float[Tensor, " V"]:
    """(V,) a third of the area of the triangles around each vertex, as `Mesh.vertex_areas`."""
    a, b, c = vertices[faces].unbind(1)
    areas = torch.linalg.cross(b - a, c - a).norm(dim=1) / 2
    return vertices.new_zeros(len(vertices)).index_add(0, faces.flatten(), (areas / 3).repeat_interleave(3))


def dirichlet_form(
    vertices: Float[Tensor, "V 3"], faces: Int[Tensor, "F 3"], functions: Float[Tensor, "V m"]
) -> Float[Tensor, "m m"]:
    """BᵀLB (m, m) of functions B (V, m), L the cotangent stiffness of `laplacian.cotangent`: ½ Σ cot α (f_i − f_j)²."""
    corners, values = vertices[faces], functions[faces]
    form = functions.new_zeros(functions.shape[1], functions.shape[1])
    for c in range(3):
        i, j = (c + 1) % 3, (c + 2) % 3
        u, v = corners[:, i] - corners[:, c], corners[:, j] - corners[:, c]
        cotangent = (u * v).sum(1) / torch.linalg.cross(u, v).norm(dim=1)
        apart = values[:, i] - values[:, j]
        form = form + apart.mT @ (cotangent[:, None] / 2 * apart)
    return form
