"""Functions that two shapes have in common before any map between them is known: what computed maps must carry over."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float, Int

from lssd_learn.errors import InputError
from lssd_learn.shapes import Eigenbasis
from lssd_learn.shapes.descriptors import wave_bounds, wave_kernel_maps, wave_kernel_signature

# Of each wave kernel. Few energies have wide bands, which survive that the levels of two shapes differ: with 200, as
# in the literature, six landmarks map bodies of different build left to right.
ENERGIES = 25


def probes(
    source: Eigenbasis,
    target: Eigenbasis,
    source_landmarks: Sequence[int] | Int[np.ndarray, " m"],
    target_landmarks: Sequence[int] | Int[np.ndarray, " m"],
) -> tuple[Float[np.ndarray, "k_source q"], Float[np.ndarray, "k_target q"]]:
    """A (k_source, q) and B (k_target, q), q corresponding functions by their coefficients at unit area.

    Wave kernel signatures and, for each landmark, wave kernel maps, at the same energies on both shapes. All have the
    same norm, so that the squared norms of the functions of one kernel add up to 1.

    Args:
        source, target: eigenbases at unit area (`at_unit_area`).
        source_landmarks, target_landmarks: (m,) corresponding vertices; none leaves intrinsic symmetries undecided.

    Raises:
        InputError: unequal numbers of landmarks, or one that is no vertex.
    """
    if len(source_landmarks) != len(target_landmarks):
        raise InputError(
            f"landmarks: expected as many on both shapes, got {len(source_landmarks)} and {len(target_landmarks)}"
        )
    bounds = wave_bounds(source, target)
    return _coefficients(source, source_landmarks, bounds), _coefficients(target, target_landmarks, bounds)


def _coefficients(basis: Eigenbasis, landmarks: Sequence[int] | np.ndarray, bounds: tuple[float, float]) -> np.ndarray:
    """(k, q) of one shape."""
    signatures = (basis.evecs * basis.mass[:, None]).T @ wave_kernel_signature(basis, ENERGIES, bounds)
    maps = wave_kernel_maps(basis, np.asarray(landmarks, dtype=int), ENERGIES, bounds)
    functions = np.hstack([signatures, maps.reshape(basis.k, -1)])
    norms = np.linalg.norm(functions, axis=0)
    return functions / np.where(norms > 0, norms, 1) / np.sqrt(ENERGIES)  # zero: a landmark on a node of all of a band
