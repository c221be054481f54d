"""New shapes in an old latent space, pushed from those of its shapes whose faces they share."""

from collections.abc import Sequence

import numpy as np
import torch

from lssd_learn.errors import InputError, check_whole
from lssd_learn.latent.sizes import tell_of_sizes_in
from lssd_learn.latent.space import LatentSpace
from lssd_learn.maps import from_correspondence
from lssd_learn.progress import track
from lssd_learn.shapes import Eigenbasis


def push_all(
    space: LatentSpace,
    bases: Sequence[Eigenbasis],
    names: Sequence[str],
    neighbours: int = 5,
    method: str = "least_squares",
) -> LatentSpace:
    """The new shapes in the language of `space`, each pushed from its nearest neighbours.

    Args:
        space: with its eigenbases, of k functions.
        bases: n eigenbases of k functions, by the Laplacian of the old ones and in vertex correspondence with them.
        names: n, for messages.
        neighbours: how many old shapes, at most, each new one is pushed from.
        method: see `LatentSpace.push`.

    Returns:
        A space of the new shapes alone: `Y` (n, k, m) and `evals` (n, k) are theirs; `spectrum`, `U` and `energy` are
        those of `space`, and the mean of the area differences is therefore not the identity.

    Raises:
        InputError: a shape with faces that no shape of `space` has, a space without its eigenbases.
    """
    check_whole("neighbours", neighbours, 1)
    pushed, evals = [], []
    for basis, name in zip(track(bases, "pushing"), names, strict=True):
        maps = {}
        for i in corresponding(space, basis, name, neighbours):
            old = space.eigenbasis(i)
            maps[i] = from_correspondence(old, basis), from_correspondence(basis, old)
        pushed.append(space.push(basis, maps, method).basis)
        evals.append(torch.tensor(np.asarray(basis.evals)).to(space.evals))
    new = space.with_shapes(torch.stack(pushed), torch.stack(evals), bases, names)
    tell_of_sizes_in(space, new)
    return new


def corresponding(space: LatentSpace, basis: Eigenbasis, name: str, neighbours: int = 5) -> list[int]:
    """The shapes of `space` nearest to `basis` by spectrum among those with its faces; fewer if there are no more.

    Raises:
        InputError: there is none.
    """
    found: list[int] = []
    for i in space.neighbours(basis.evals, len(space)):
        if len(found) < neighbours and _has_faces(space, i, basis.connectivity):
            found.append(i)
        if len(found) == neighbours:
            break
    if not found:
        raise _unknown_faces(space, name, basis.connectivity, len(basis.mass))
    return found


def check_corresponds(space: LatentSpace, name: str, connectivity: str | None, vertices: int) -> None:
    """Refuse a shape that cannot be pushed, before its eigenbasis is computed.

    Raises:
        InputError: no shape of `space` has its faces.
    """
    if not corresponds(space, connectivity):
        raise _unknown_faces(space, name, connectivity, vertices)


def corresponds(space: LatentSpace, connectivity: str | None) -> bool:
    """Whether some shape of `space` has these faces."""
    return any(_has_faces(space, i, connectivity) for i in range(len(space)))


def _has_faces(space: LatentSpace, i: int, connectivity: str | None) -> bool:
    if space.bases is None:
        raise InputError("this latent space was loaded without its eigenbases, from which new shapes are pushed")
    return connectivity is not None and space.bases[i].connectivity == connectivity


def _unknown_faces(space: LatentSpace, name: str, connectivity: str | None, vertices: int) -> InputError:
    old, theirs = space.eigenbasis(0), space.names[0] if space.names else "shape 0"
    kind = "points and no faces" if connectivity is None else "vertices and other faces"
    return InputError(
        f"{name}: expected a mesh in vertex correspondence with the shapes the latent space was fitted to, with the "
        f"faces of {theirs} ({len(old.mass):,} vertices), or maps=kernel_matching; got {vertices:,} {kind}"
    )
