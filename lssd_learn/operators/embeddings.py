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
from lssd_learn.shapes.kabsch import nearest_rotation, vertex_error

TRIED = 16  # known shapes that are drawn from the others, to see how their detail is best lent


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
    Where the faces of a mesh are inside out then, it is the other one. Detail is added as it is,
    x_i + Φ_iY_i (x̂ − x̂_i), or, of a mesh, turns with its part of the body, see `with_turned_detail`. A neighbour in the
    same pose has nothing to turn: how near one has to be is learnt from known shapes, drawn from the others both ways.

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
    near = _near_enough(space, shapes, known)
    for x in smooth_embedding(G.to(space.Y)):
        Q = nearest_orthogonal(x.mT @ known)  # lays it on each of them
        laid, i, apart = _nearest(x @ Q, known)
        if _is_inside_out(space.to_shape(laid[i], i).cpu().numpy(), shapes[i]):
            image = -x * Q[i].det().sign()
            Q = torch.tensor(nearest_rotation((image.mT @ known).cpu().numpy())).to(x)
            laid, i, apart = _nearest(image @ Q, known)
        smooth, its = (space.to_shape(each[i], i).cpu().numpy() for each in (laid, known))
        added, apart = shapes[i].vertices + smooth - its, apart / float(x.norm())
        vertices = added if apart <= near else _with_turned(shapes[i], its, smooth, space, i)
        found.append(Laid(vertices, smooth, i, apart))
    return found


def _with_turned(shape: Shape, before: np.ndarray, after: np.ndarray, space: LatentSpace, i: int) -> np.ndarray:
    if isinstance(shape, Mesh):
        return with_turned_detail(shape, before, after, _measure(space, i))
    return shape.vertices + after - before


def _near_enough(space: LatentSpace, shapes: Sequence[Shape], known: Tensor) -> float:
    """The distance up to which detail is better added as it is, by some known shapes, each drawn from the others.

    Zero where that cannot be told: the vertices of two shapes are compared if they have the same faces.
    """
    errors = []
    for s in dict.fromkeys(np.linspace(0, len(shapes) - 1, TRIED, dtype=int).tolist()):
        x = known[s]
        Q = torch.tensor(nearest_rotation((x.mT @ known).cpu().numpy())).to(x)
        Q[s] *= torch.nan  # not from itself
        laid, i, apart = _nearest(x @ Q, known)
        if not all(isinstance(shapes[j], Mesh) for j in (s, i)) or shapes[s].connectivity != shapes[i].connectivity:
            continue
        smooth, its = (space.to_shape(each[i], i).cpu().numpy() for each in (laid, known))
        drawn = shapes[i].vertices + smooth - its, _with_turned(shapes[i], its, smooth, space, i)
        errors.append((apart / float(x.norm()), *(vertex_error(some, shapes[s].vertices) for some in drawn)))
    errors.sort()
    totals = [sum(added if place < count else turned for place, (_, added, turned) in enumerate(errors))
              for count in range(len(errors) + 1)]  # fmt: skip
    best = int(np.argmin(totals))
    return errors[best - 1][0] if best else 0.0


def _nearest(laid: Tensor, known: Tensor) -> tuple[Tensor, int, float]:
    """What was laid on each of the shapes, the one that it is nearest to, and how near."""
    apart = (laid - known).flatten(1).norm(dim=1).nan_to_num(torch.inf)
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
