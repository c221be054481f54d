"""The average of several meshes in vertex correspondence: what a latent shape is when nothing is truncated."""

from collections.abc import Iterable

import numpy as np
from scipy.sparse import csr_array

from lssd_learn.errors import InputError
from lssd_learn.shapes.eigenbasis import Eigenbasis, eigenbasis_of
from lssd_learn.shapes.laplacian import laplacian as laplacian_of
from lssd_learn.shapes.mesh import Shape


def average_eigenbasis(shapes: Iterable[Shape], k: int, laplacian: str = "auto") -> Eigenbasis:
    """The k lowest eigenfunctions of the shape with stiffness (1/n) Σ L_i and masses (1/n) Σ M_i: L̄Φ₀ = M̄Φ₀Λ₀.

    No embedding in space need have them. It is the oracle of a latent space: with all eigenfunctions of every shape and
    true maps, Φ_iY_i = Φ₀ and the latent spectrum is Λ₀.

    Args:
        shapes: n meshes of one connectivity; each is looked at once.
        k, laplacian: see `eigenbasis`.

    Raises:
        InputError: shapes that are not in vertex correspondence, k out of range, no shape.

    Source: Theorem `latentshape` of the paper.
    """
    sums: tuple[csr_array, np.ndarray] | None = None
    count, connectivity = 0, None
    for shape in shapes:
        if shape.connectivity is None or (count and shape.connectivity != connectivity):
            raise InputError(f"shapes: an average needs meshes with the same faces, number {count} differs")
        L, M = laplacian_of(shape, laplacian)
        sums = (L, M) if sums is None else (sums[0] + L, sums[1] + M)
        count, connectivity = count + 1, shape.connectivity
    if sums is None or not 1 <= k < len(sums[1]):
        most = len(sums[1]) - 1 if sums else 0
        raise InputError(f"k: expected 1 to {most}, fewer than the vertices of {count} shapes, got {k}")
    return eigenbasis_of(sums[0] / count, sums[1] / count, k, connectivity)
