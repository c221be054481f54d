"""Shapes of given Gram forms, in closed form: their smooth part, with the detail of a shape that is known."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from torch import Tensor

from lssd_learn.errors import InputError
from lssd_learn.latent.extrinsic import latent_coordinates, smooth_embedding
from lssd_learn.latent.orthogonal import nearest_orthogonal
from lssd_learn.latent.space import LatentSpace
from lssd_learn.shapes import Shape


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

    x_i + Φ_iY_i (x̂ − x̂_i), where x̂ of the form is laid on x̂_i by the best rotation or reflection: which of two mirror
    images it is no Gram form says. What of the detail would turn with its part of the body does not turn.

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
        laid = x @ nearest_orthogonal(x.mT @ known)  # on each of them
        apart = (laid - known).flatten(1).norm(dim=1)
        i = int(apart.argmin())
        smooth = space.to_shape(laid[i], i).cpu().numpy()
        vertices = shapes[i].vertices + space.to_shape(laid[i] - known[i], i).cpu().numpy()
        found.append(Laid(vertices, smooth, i, float(apart[i] / x.norm())))
    return found
