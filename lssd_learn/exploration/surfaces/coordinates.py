"""The coordinates of all shapes as functions on the latent shape, laid upon each other there.

x̂_i = Y_i⁺Φ_iᵀM_i(X_i − c_i) needs no vertex correspondence, only the maps that the latent space was made of. Laid upon
each other (generalised Procrustes analysis, without scale: size is a part of shape here, as in form space), they are n
vectors of one space, which has means, slopes and principal components. Φ_iY_ix̂ takes each of these to the vertices of
shape i.
"""

from dataclasses import dataclass

import numpy as np
import torch
from jaxtyping import Bool, Float

from lssd_learn.collections.eigenbases import StoredBases
from lssd_learn.collections.procrustes import procrustes
from lssd_learn.errors import InputError
from lssd_learn.latent import LatentSpace
from lssd_learn.latent.extrinsic import latent_coordinates
from lssd_learn.shapes.kabsch import kabsch
from lssd_learn.shapes.rigid import MIRROR, TIE

SIDE = np.diag([-1.0, 1.0, 1.0])


@dataclass(frozen=True, eq=False)
class Coordinates:
    """Coordinates of n shapes in m functions, in the units of the shapes, as one of the shapes lies.

    Attributes:
        x: (n, m, 3), about the centre of mass of that shape.
        base: its position, the shape that the others are laid on.
        mirrored: (n,) bool, shapes that are laid there as their mirror images.
    """

    x: Float[np.ndarray, "n m 3"]
    base: int
    mirrored: Bool[np.ndarray, " n"]


def coordinates(latent: LatentSpace, base: int, mirror: str = "auto", workers: int | None = None) -> Coordinates:
    """Lay the shapes of a latent space upon each other.

    Turns and shifts are those of least Σ ‖x̂_iR_i + 1t_i − mean‖², the mean of squares over the latent shape. A shape
    is mirrored first where its maps have carried the left of one shape to the right of another, as where left bones and
    right ones are compared: seen by how it lies on the base.

    Args:
        latent: n shapes, with eigenbases that know coordinates.
        base: position of the shape that stays as it lies.
        mirror: of the collection, see `shapes.rigid.rigid`: "forbid" mirrors nothing, "allow" what lies better so,
            "auto" what clearly does.
        workers: see `in_parallel`, for coordinates that are not known yet.

    Raises:
        InputError: another value of `mirror`; as `latent_coordinates`.
    """
    if mirror not in MIRROR:
        raise InputError(f"mirror={mirror}: expected one of {', '.join(MIRROR)}")
    if isinstance(latent.bases, StoredBases):
        latent.bases.measure(workers)
    x, one = latent_coordinates(latent).cpu().numpy(), _constant(latent)
    shifts = one @ x / (one @ one)
    x = x - one[:, None] * shifts[:, None]
    mirrored = np.array([_is_mirrored(each, x[base], mirror) for each in x])
    x = np.where(mirrored[:, None, None], x @ SIDE, x)
    turns = procrustes(x, np.arange(len(x)))
    back = turns @ turns[base].T  # by way of the mean to where the base lies
    return Coordinates(x @ back + one[:, None] * shifts[base], base, mirrored)


def _constant(latent: LatentSpace) -> Float[np.ndarray, " m"]:
    """(m,) the constant 1 on the latent shape, the mean of what it is by each shape."""
    found = torch.zeros(latent.keep).to(latent.Y)
    for i in range(len(latent)):
        found += latent.from_shape(np.ones(len(latent.eigenbasis(i).mass)), i) / len(latent)
    return found.cpu().numpy()


def _is_mirrored(x: np.ndarray, goal: np.ndarray, mirror: str) -> bool:
    """Whether x (m, 3) lies better on another as its mirror image."""
    if mirror == "forbid":
        return False
    own, image = (float(np.linalg.norm(one @ kabsch(one, goal) - goal)) for one in (x, x @ SIDE))
    return (TIE if mirror == "auto" else 1) * image < own
