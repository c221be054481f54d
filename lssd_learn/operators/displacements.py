"""Derivatives of operators along many fields of displacements at once, where functions stay at the vertices.

Such operators are linear in what the vertices weigh: areas, cotangents, squared distances from the centre. So the
derivatives of these, a number a vertex or an edge and way, go through one product of matrices into those of all
entries. Differentiating the operators themselves would take such a product for each way.
"""

import warnings
from collections.abc import Sequence

import torch
from jaxtyping import Float, Int
from torch import Tensor

from lssd_learn.differentiable.forms import cotangents, vertex_masses
from lssd_learn.differentiable.operators import KINDS, check_differentiable, conformal_root
from lssd_learn.latent.differences import Seen
from lssd_learn.latent.extrinsic import latent_root
from lssd_learn.operators.vectors import entries
from lssd_learn.shapes.moments import pair_parts

TOGETHER = 60  # ways that are differentiated at once
ROWS = 1024  # vertices or edges whose products of functions are held at once


def operator_derivatives(
    vertices: Float[Tensor, "V 3"],
    faces: Int[Tensor, "F 3"],
    functions: Float[Tensor, "V m"],
    seen: Seen,
    fields: Float[Tensor, "V d"],
    kinds: Sequence[str] = KINDS,
) -> Float[Tensor, "3*d n"]:
    """How the `entries` of `vertex_operators`, channel after channel, change as vertices move along fields.

    Args:
        vertices, faces, functions, seen, kinds: see `vertex_operators`.
        fields: d of them, (V, d); each is three ways, along x, y and z: way 3 j + t moves vertex v by fields[v, j]
            along axis t.

    Raises:
        InputError: as `vertex_operators`.
    """
    check_differentiable(kinds)
    B = functions.to(vertices)
    pairs, edge_of_corner = _edges(faces)
    values, roots = {}, {"conformal": lambda: conformal_root(seen).to(B), "extrinsic": lambda: latent_root(seen).to(B)}
    for kind in kinds:
        values[kind] = B if kind == "area" else B @ (root.diag() if (root := roots[kind]()).ndim == 1 else root)

    def weights(X: Tensor) -> tuple[Tensor, ...]:
        """What operators are linear in, and of extrinsic ones what is left."""
        mass, found = vertex_masses(X, faces), []
        for kind in kinds:
            if kind == "area":
                found.append(mass)
            elif kind == "conformal":
                halves = cotangents(X, faces).flatten() / 2
                found.append(halves.new_zeros(len(pairs)).index_add(0, edge_of_corner, halves))
            else:
                found.extend(pair_parts(X, mass, values[kind])[:2])
        return tuple(found)

    def along(way: Tensor) -> tuple[Tensor, ...]:
        return torch.func.jvp(weights, (vertices,), (way,))[1]

    ways = (fields.T[:, None, :, None] * torch.eye(3).to(vertices)[:, None]).flatten(0, 1)
    with warnings.catch_warnings():  # of torch against itself, on the first call
        warnings.filterwarnings("ignore", r".*torch\.jit", DeprecationWarning)
        slopes = iter(torch.func.vmap(along, chunk_size=TOGETHER)(ways))
    found = []
    for kind in kinds:
        slope, some = next(slopes), values[kind]
        if kind == "conformal":
            some = some[pairs[:, 0]] - some[pairs[:, 1]]
        change = torch.zeros(len(ways), 1).to(vertices)
        for weight, few in zip(slope.split(ROWS, dim=1), some.split(ROWS), strict=True):
            change = change + weight @ entries(few[:, :, None] * few[:, None, :])
        found.append(change + entries(next(slopes)) if kind == "extrinsic" else change)
    return torch.cat(found, dim=1)


def _edges(faces: Int[Tensor, "F 3"]) -> tuple[Int[Tensor, "E 2"], Int[Tensor, " F*3"]]:
    """The edges of a mesh, and of each corner of each face in a row the edge across."""
    across = torch.stack([faces[:, [1, 2]], faces[:, [2, 0]], faces[:, [0, 1]]], dim=1)
    pairs, numbers = across.flatten(0, 1).sort(dim=1)[0].unique(dim=0, return_inverse=True)
    return pairs, numbers
