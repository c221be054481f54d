"""Maps, latent bases and operators of differentiable eigenbases: of shapes among each other, or in a given space.

What `latent` computes at scale from arrays, written out with dense tensors, for as many shapes as one takes gradients
of. Every step takes each shape's functions as a span, and so needs no gap but the ones behind the last functions taken.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import cast

import numpy as np
import torch
from jaxtyping import Float, Int
from torch import Tensor

from lssd_learn.differentiable.eigenbasis import Basis
from lssd_learn.differentiable.frames import CLUSTER, frame, inverse_root
from lssd_learn.differentiable.operators import KINDS, check_differentiable, conformal_root
from lssd_learn.errors import InputError
from lssd_learn.latent.differences import Seen, pseudo_inverse
from lssd_learn.latent.extrinsic import latent_root
from lssd_learn.latent.push import push_least_squares
from lssd_learn.latent.space import LatentSpace
from lssd_learn.shapes import Eigenbasis
from lssd_learn.shapes.moments import pair_form

Maps = Callable[[int, int], Tensor]


@dataclass(frozen=True, eq=False)
class Latent:
    """A canonical latent basis of n shapes.

    Attributes:
        Y: (n, k, m), as `LatentSpace.Y`.
        form: Λ₀ (m, m): the frequencies on the diagonal, see `Basis.form`.
    """

    Y: Float[Tensor, "n k m"]
    form: Float[Tensor, "m m"]

    @property
    def spectrum(self) -> Float[Tensor, " m"]:
        """(m,) the frequencies of the latent shape."""
        return self.form.diagonal()


def functional_map(
    source: Basis | Eigenbasis, target: Basis | Eigenbasis, vertices: Int[np.ndarray, " V_target"] | None = None
) -> Float[Tensor, "k_target k_source"]:
    """C = ΦₜᵀMₜΠΦₛ, `maps.from_correspondence` with gradients to both meshes, of which one may be an array's.

    Args:
        source, target: eigenbases.
        vertices: (V_target,) for each vertex of the target the vertex of the source; None is vertex identity. They are
            numbers: nothing is differentiated by them.

    Raises:
        InputError: another number of vertices.
    """
    like = next((basis.evecs for basis in (source, target) if isinstance(basis, Basis)), torch.zeros(0).double())
    (carried, _), (Phi, mass) = _tensors(source, like), _tensors(target, like)
    if vertices is not None:
        carried = carried[torch.as_tensor(np.asarray(vertices)).to(like.device)]
    if len(carried) != len(Phi):
        raise InputError(f"vertices: expected one for each of the {len(Phi)} of the target, got {len(carried)}")
    return (mass[:, None] * Phi).mT @ carried


def _tensors(basis: Basis | Eigenbasis, like: Tensor) -> tuple[Tensor, Tensor]:
    evecs, mass = basis.evecs, basis.mass
    return torch.as_tensor(evecs).to(like), torch.as_tensor(mass).to(like)


def latent_basis(
    bases: Basis | Sequence[Basis],
    size: int,
    keep: int,
    edges: Sequence[tuple[int, int]] | None = None,
    maps: Maps | None = None,
    clusters: float = CLUSTER,
) -> Latent:
    """The canonical consistent latent basis of a network, `LatentSpace.fit` with gradients.

    Dense: (n·k)³ operations.

    Args:
        bases: n of k functions.
        size, keep: as in `LatentSpace.fit`; neither may cut a cluster of equal eigenvalues.
        edges: pairs of shape numbers, both directions meant; None is the clique.
        maps: (i, j) → C_ij (k, k); None is vertex identity.
        clusters: of latent frequencies, see `eigenbasis`.

    Raises:
        InputError: sizes out of range; in the backward pass, a cluster that is cut.
    """
    n, k = len(bases), bases[0].evecs.shape[-1]
    if not 1 <= keep <= size <= k:
        raise InputError(f"size={size}, keep={keep}: expected 1 ≤ keep ≤ size ≤ {k}, the functions of each shape")
    pairs = [(i, j) for i in range(n) for j in range(i)] if edges is None else [tuple(map(int, e)) for e in edges]
    identity = torch.eye(k).to(bases[0].evecs)
    blocks = [[torch.zeros_like(identity) for _ in range(n)] for _ in range(n)]
    for i, j in [*pairs, *((j, i) for i, j in pairs)]:  # Σ ‖C_ij y_i − y_j‖²
        C = functional_map(bases[i], bases[j]) if maps is None else maps(i, j)
        blocks[i][i] = blocks[i][i] + C.mT @ C
        blocks[j][j] = blocks[j][j] + identity
        blocks[i][j], blocks[j][i] = blocks[i][j] - C.mT, blocks[j][i] - C
    W = torch.cat([torch.cat(row, dim=1) for row in blocks])
    Y = frame(W, size, float("inf"))[0].reshape(n, k, size) * n**0.5
    E = sum(y.mT @ basis.form @ y for y, basis in zip(Y, bases, strict=True))
    U, form = frame(cast(Tensor, E) / n, keep, clusters)
    Y = Y @ U
    sign = torch.where((Y.detach() ** 3).sum((0, 1)) < 0, -1.0, 1.0).to(Y)  # as `canonical_basis`
    return Latent(Y * sign, sign[:, None] * form * sign)


def latent_operators(
    latent: Latent, bases: Basis | Sequence[Basis], kinds: Sequence[str] = KINDS, pieces: int = 1
) -> Float[Tensor, "n channels m m"]:
    """(n, channels, m, m) symmetric operators, `stack_differences` with gradients to all meshes.

    Args:
        latent: of the bases.
        bases: n.
        kinds: some of area, conformal, extrinsic.
        pieces: of how many the meshes are: as many functions have no frequency.

    Raises:
        InputError: a difference of another kind.
    """
    check_differentiable(kinds)
    forms = [torch.stack([_form(b, y, kind) for b, y in zip(bases, latent.Y, strict=True)]) for kind in kinds]
    found = []
    for kind, form in zip(kinds, forms, strict=True):
        if kind == "area":
            found.append(form)
            continue
        average = latent.form if kind == "conformal" else form.mean(0)
        live = pseudo_inverse(latent.spectrum.detach(), pieces) > 0
        root, places = torch.zeros_like(average), live.nonzero().flatten()
        root[places[:, None], places] = inverse_root(average[live][:, live])
        found.append(root @ form @ root)
    return torch.stack(found, dim=1)


def pushed_functions(
    space: LatentSpace, basis: Basis, neighbours: Sequence[int], vertices: Mapping[int, np.ndarray] | None = None
) -> Float[Tensor, "k m"]:
    """Y (k, m) of a mesh in a latent space that stays as it is, by least squares over some of its shapes.

    Args:
        space: with its eigenbases, of as many functions.
        basis: of the mesh.
        neighbours: positions in the space, as `space.neighbours` gives them.
        vertices: neighbour → for each vertex of the mesh that of the neighbour; None is vertex identity. The way back
            is taken as the adjoint of the map there, in the inner products of both.
    """
    Ys = [space.basis(i).to(basis.evecs) for i in neighbours]
    there, back = [], []
    for i in neighbours:
        old, match = space.eigenbasis(i), None if vertices is None else vertices[i]
        there.append(functional_map(old, basis, match))
        back.append(functional_map(basis, old) if match is None else there[-1].mT)
    return push_least_squares(Ys, there, back)


def pushed_operators(
    space: Seen | LatentSpace, basis: Basis, Y: Float[Tensor, "k m"], kinds: Sequence[str] = KINDS
) -> Float[Tensor, "channels m m"]:
    """(channels, m, m) symmetric operators of a mesh in a latent space that stays as it is.

    Args:
        space: what they are relative to.
        basis, Y: of the mesh, see `pushed_functions`.
        kinds: some of area, conformal, extrinsic.

    Raises:
        InputError: a difference of another kind; what `reference` raises.
    """
    check_differentiable(kinds)
    found = []
    for kind in kinds:
        form = _form(basis, Y, kind)
        if kind != "area":
            root = conformal_root(space).diag() if kind == "conformal" else latent_root(space)
            form = root.to(form) @ form @ root.to(form)
        found.append(form)
    return torch.stack(found)


def _form(basis: Basis, Y: Tensor, kind: str) -> Tensor:
    """A quadratic form of a mesh on the functions that Y carries to it."""
    if kind == "area":
        return Y.mT @ Y
    if kind == "conformal":
        return Y.mT @ basis.form @ Y
    return pair_form(basis.vertices, basis.mass, basis.evecs @ Y)[0]
