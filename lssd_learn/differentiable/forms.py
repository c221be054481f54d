"""The cotangent Laplacian of a mesh as functions of its vertices, differentiable: masses, cotangents, energies."""

import torch
from jaxtyping import Float, Int
from torch import Tensor


def vertex_masses(vertices: Float[Tensor, "V 3"], faces: Int[Tensor, "F 3"]) -> Float[Tensor, " V"]:
    """(V,) a third of the area of the triangles around each vertex, as `Mesh.vertex_areas`."""
    a, b, c = vertices[faces].unbind(1)
    areas = torch.linalg.cross(b - a, c - a).norm(dim=1) / 2
    return vertices.new_zeros(len(vertices)).index_add(0, faces.flatten(), (areas / 3).repeat_interleave(3))


def dirichlet_form(
    vertices: Float[Tensor, "V 3"], faces: Int[Tensor, "F 3"], functions: Float[Tensor, "V m"]
) -> Float[Tensor, "m m"]:
    """BᵀLB (m, m) of functions B (V, m), L the cotangent stiffness of `laplacian.cotangent`: ½ Σ cot α (f_i − f_j)²."""
    form, values = functions.new_zeros(functions.shape[1], functions.shape[1]), functions[faces]
    for c, cotangent in enumerate(cotangents(vertices, faces).unbind(1)):
        apart = values[:, (c + 1) % 3] - values[:, (c + 2) % 3]
        form = form + apart.mT @ (cotangent[:, None] / 2 * apart)
    return form


def cotangents(vertices: Float[Tensor, "V 3"], faces: Int[Tensor, "F 3"]) -> Float[Tensor, "F 3"]:
    """(F, 3) of the angle at each corner of each triangle."""
    corners = vertices[faces]
    found = []
    for c in range(3):
        u, v = (corners[:, (c + step) % 3] - corners[:, c] for step in (1, 2))
        found.append((u * v).sum(1) / torch.linalg.cross(u, v).norm(dim=1))
    return torch.stack(found, dim=1)
