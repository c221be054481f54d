"""Extrinsic differences: what a shape does to distances through space, which no bending leaves alone.

Area and conformal differences see a surface from inside, and are the same in whatever way it lies in space. These see
how it lies: E(f, g), the mean of (f_a − f_b)(g_a − g_b) over all pairs of points with weights m_a m_b ‖x_a − x_b‖²,
compares functions the more the farther two points lie apart. No rigid motion, reflection or change of size changes it.
`docs/operators.md` says what each sees.
"""

from collections.abc import Iterator, Sequence

import numpy as np
import torch
from jaxtyping import Float
from torch import Tensor

from lssd_learn.errors import InputError
from lssd_learn.latent.differences import Difference, ask, pieces, pseudo_inverse, reference, register
from lssd_learn.shapes import Eigenbasis
from lssd_learn.shapes.moments import Moments

NAME = "extrinsic"
TOGETHER = 32  # shapes whose forms are held at once


def extrinsic_forms(seen) -> Float[Tensor, "n m m"]:
    """YᵀEY (n, m, m): the form of every shape carried to the functions that it is seen by.

    Args:
        seen: a `Seen`, or what has its attributes.

    Raises:
        InputError: eigenbases that are not there, or know no coordinates.
    """
    each, found = _moments(seen), []
    for some in seen.Y.split(TOGETHER):
        forms = torch.from_numpy(np.stack([next(each).form for _ in some])).to(some)
        found.append(torch.bmm(some.mT, torch.bmm(forms, some)))
    return torch.cat(found)


def extrinsic_difference(seen, symmetric: bool = False) -> Float[Tensor, "n m m"]:
    """D^E = E₀⁺ YᵀEY (n, m, m), or its symmetric form E₀^-½ YᵀEY E₀^-½, which has the same eigenvalues.

    E₀ is the average of the forms, so that a shape like the latent one has the identity. The constant is null, and with
    it the functions that are constant on each piece of shapes in several, as of conformal differences. On the others E₀
    is well conditioned, see `pair_form`.

    Args:
        seen: a `Seen`, or what has its attributes.

    Raises:
        InputError: as `extrinsic_forms`.
    """
    forms = extrinsic_forms(seen)
    root = latent_root(seen, forms)
    return root @ forms @ root if symmetric else root @ root @ forms


def latent_root(seen, forms: Float[Tensor, "n m m"] | None = None) -> Float[Tensor, "m m"]:
    """E₀^-½ (m, m), symmetric; rows and columns of null functions, the same as of conformal differences, vanish.

    Args:
        seen: a `Seen`, or what has its attributes.
        forms: its `extrinsic_forms`, where they are known.
    """

    def of(source) -> Tensor:
        return extrinsic_forms(source) if forms is None or source is not seen else forms

    live = pseudo_inverse(seen.spectrum, pieces(seen.evals)) > 0
    E0 = reference(seen, NAME, of)
    energies, V = torch.linalg.eigh(E0[live][:, live])
    root, places = torch.zeros_like(E0), live.nonzero().flatten()
    root[places[:, None], places] = (V / energies.sqrt()) @ V.mT
    return root


def latent_coordinates(seen) -> Float[Tensor, "n m 3"]:
    """x̂ = Y⁺ΦᵀM(X − c) (n, m, 3): the coordinate functions about the centre of mass, on the latent shape.

    Args:
        seen: a `Seen`, or what has its attributes.

    Raises:
        InputError: as `extrinsic_forms`.
    """
    coordinates = np.stack([each.coordinates for each in _moments(seen)])
    return torch.linalg.pinv(seen.Y) @ torch.from_numpy(coordinates).to(seen.Y)


def gram(seen) -> Float[Tensor, "n m m"]:
    """x̂x̂ᵀ (n, m, m) of rank three, of `latent_coordinates`.

    Not a difference: the identity is no shape. Rotations and reflections of a shape leave it, and it has all that the m
    functions know of the embedding: see `smooth_embedding`. In (unit of length)⁴.

    Args:
        seen: a `Seen`, or what has its attributes.

    Raises:
        InputError: as `extrinsic_forms`.
    """
    x = latent_coordinates(seen)
    return x @ x.mT


def smooth_embedding(G: Float[Tensor, "*n m m"]) -> Float[Tensor, "*n m 3"]:
    """x̂ (…, m, 3) of Gram forms x̂x̂ᵀ (…, m, m), up to a rotation or reflection: its axes are the principal ones.

    Of a matrix of higher rank, as algebra or a net may give, that of the nearest one of rank three.
    `LatentSpace.to_shape(x̂, i)` are points of shape i: the smooth shape, without what m functions do not see.
    """
    evals, V = torch.linalg.eigh((G + G.mT) / 2)
    evals, V = evals[..., -3:].flip(-1), V[..., -3:].flip(-1)
    return V * evals.clamp(min=0).sqrt()[..., None, :]


def _moments(seen) -> Iterator[Moments]:
    """Of each shape, read when its turn comes."""
    bases: Sequence[Eigenbasis] | None = seen.bases
    if bases is None:
        raise InputError(f"{NAME}: expected a latent space with its eigenbases")
    for i in range(len(bases)):
        found: Moments | None = ask(bases, i, "moments")
        if found is None:
            raise InputError(f"{NAME}: expected eigenbases with moments, that of shape {i} has none")
        yield found


EXTRINSIC = register(
    Difference(
        name=NAME,
        compute=lambda seen: extrinsic_difference(seen, symmetric=True),
        plain=extrinsic_difference,
        constant_is_null=True,
        tells="more lies farther from the rest",
        asks=("moments",),
    )
)
