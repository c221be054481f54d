"""How far a latent basis turns when the collection changes: canonical ones should turn less than plain ones."""

import numpy as np
import torch
from jaxtyping import Float
from scipy.linalg import subspace_angles
from torch import Tensor

from lssd_learn.errors import InputError


def principal_angles(Y, Z) -> Float[Tensor, " q"]:
    """Angles in radians, descending, between the functions that two latent bases span on the shapes both know.

    Args:
        Y, Z: (s, k, m) and (s, k, p), the bases on the same s shapes in their eigenfunctions: `LatentSpace.Y[shared]`,
            or `ConsistentBasis.Y[shared]` of the plain basis; cut to the first functions, since all of a plain basis
            span what its canonical form spans.

    Returns:
        (min(m, p),) float64.

    Raises:
        InputError: not on the same shapes and eigenfunctions.
    """
    Y, Z = _stacked(Y, Z)
    return torch.from_numpy(subspace_angles(Y, Z))


def change_of_basis(Y, Z) -> Float[Tensor, "m p"]:
    """T (m, p) float64 with Y_iT nearest to Z_i on all the shapes: diagonal where every function stayed what it was.

    Arguments and errors as `principal_angles`. Source: the paper's Figure average_shape (b, c), there on one shape.
    """
    Y, Z = _stacked(Y, Z)
    return torch.from_numpy(np.linalg.lstsq(Y, Z, rcond=None)[0])


def off_band(T, width: int = 0) -> float:
    """The part of the energy of a change of basis T (m, p) off the band |i − j| ≤ width: 0 is one that only scales.

    With width 0 it is the strict off-diagonal part. Neighbours of nearly equal frequency change places easily, which a
    width of a few forgives.
    """
    T = torch.as_tensor(T).double().cpu().numpy()
    rows, columns = np.indices(T.shape)
    return float((T[np.abs(rows - columns) > width] ** 2).sum() / (T**2).sum())


def _stacked(Y, Z) -> tuple[np.ndarray, np.ndarray]:
    """(s k, m) and (s k, p) float64."""
    Y, Z = (torch.as_tensor(basis).double().cpu() for basis in (Y, Z))
    if Y.ndim != 3 or Z.ndim != 3 or Y.shape[:2] != Z.shape[:2]:
        raise InputError(f"bases: expected (s, k, m) and (s, k, p) on the same shapes, got {Y.shape} and {Z.shape}")
    return Y.flatten(0, 1).numpy(), Z.flatten(0, 1).numpy()
