"""Shapes of given Gram forms, without training: their smooth part, with the detail of a shape that is known."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import torch
from jaxtyping import Float
from torch import Tensor

from lssd_learn.errors import InputError
from lssd_learn.latent.extrinsic import latent_coordinates, smooth_embedding
from lssd_learn.latent.orthogonal import nearest_orthogonal
from lssd_learn.latent.space import LatentSpace
from lssd_learn.operators.rigidity import with_turned_detail
from lssd_learn.shapes import Mesh, Shape
from lssd_learn.shapes.kabsch import nearest_rotation


@dataclass(frozen=True, eq=False)
class Laid:
    """A shape of a Gram form.

    Attributes:
        vertices: (V, 3), of the shape that lends its detail, moved.
        smooth: (V, 3) its smooth part.
        nearest: that shape's position in the space.
        apart: how far the smooth parts of the two are apart, ‖x̂ − x̂_i‖ / ‖x̂‖.
    """

    vertices: Float[np.ndarray, "V 3"]
    smooth: Float[np.ndarray, "V 3"]
    nearest: int
    apart: float


def shapes_of_gram(G: Float[Tensor, "s m m"], space: LatentSpace, shapes: Sequence[Shape]) -> list[Laid]:
    """Each the smooth shape of a Gram form, and the detail of the shape of `space` whose smooth part lies nearest.

    x̂ of the form is laid on x̂_i by the best rotation or reflection: which of two mirror images it is no Gram form says.
    Where the faces of a mesh are inside out then, it is the other one. The detail of a mesh turns with its part of the
    body, see `with_turned_detail`. That of a cloud does not: x_i + Φ_iY_i (x̂ − x̂_i).

    Args:
        G: (s, m, m), see `latent.gram`; a matrix of higher rank counts as the nearest of rank three.
        space: with its eigenbases, that know coordinates.
        shapes: those of `space`; only the nearest are asked for.

    Raises:
        InputError: other numbers of shapes or functions; as `latent.gram`.
    """
    if len(shapes) != len(space):
        raise InputError(f"shapes: expected the {len(space)} of the latent space, got {len(shapes)}")
    if G.ndim != 3 or G.shape[1:] != (space.keep, space.keep):
        raise InputError(f"G: expected forms (s, {space.keep}, {space.keep}), got {tuple(G.shape)}")
    known, found = latent_coordinates(space), []
    for x in smooth_embedding(G.to(space.Y)):
        Q = nearest_orthogonal(x.mT @ known)  # lays it on each of them
        laid, i, apart = _nearest(x @ Q, known)
        if _is_inside_out(space.to_shape(laid[i], i).cpu().numpy(), shapes[i]):
            image = -x * Q[i].det().sign()
            Q = torch.tensor(nearest_rotation((image.mT @ known).cpu().numpy())).to(x)
            laid, i, apart = _nearest(image @ Q, known)
        smooth, its = (space.to_shape(each[i], i).cpu().numpy() for each in (laid, known))
        vertices = shapes[i].vertices + smooth - its
        if isinstance(shape := shapes[i], Mesh):
            vertices = with_turned_detail(shape, its, smooth, _measure(space, i))
        found.append(Laid(vertices, smooth, i, apart / float(x.norm())))
    return found


def _nearest(laid: Tensor, known: Tensor) -> tuple[Tensor, int, float]:
    """What was laid on each of the shapes, the one that it is nearest to, and how near."""
    apart = (laid - known).flatten(1).norm(dim=1)
    return laid, int(apart.argmin()), float(apart.min())


def _is_inside_out(smooth: Float[np.ndarray, "V 3"], shape: Shape) -> bool:
    """Whether faces that look outward on the shape look inward on its smooth likeness."""
    if not isinstance(shape, Mesh):
        return False
    corners = ((x - x.mean(0))[shape.faces] for x in (smooth, shape.vertices))
    volumes = [np.einsum("fi,fi->", np.cross(c[:, 0], c[:, 1]), c[:, 2]) for c in corners]
    return bool(volumes[0] * volumes[1] < 0)


def _measure(space: LatentSpace, i: int) -> Float[np.ndarray, "m V"]:
    """Y⁺ΦᵀM: the latent coefficients of functions on shape i."""
    basis = space.eigenbasis(i)
    weighted = np.asarray(basis.evecs, dtype=float).T * np.asarray(basis.mass)
    return torch.linalg.pinv(space.Y[i]).cpu().numpy() @ weighted
