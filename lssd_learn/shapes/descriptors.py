"""What tells shapes, and points of a shape, apart before any map: for the network's neighbours and for computed maps.

The signatures of points are those of the shape at unit area, so that neither its unit of length nor its size matters.
"""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float, Int

from lssd_learn.errors import InputError, check_whole
from lssd_learn.shapes.eigenbasis import Eigenbasis

WIDTH = 7.0  # of a wave kernel's energy band, in steps between energies: Aubry et al.'s choice


def shape_dna(basis: Eigenbasis, unit_area: bool = False) -> Float[np.ndarray, " k"]:
    """(k,) the eigenvalues of a shape, in 1 / (unit of length)²; its distances are Euclidean.

    Args:
        basis: of the shape.
        unit_area: take them as if the shape had unit area (no unit): without, they mostly tell areas apart.

    Reference:
        Reuter, Wolter and Peinecke, "Laplace–Beltrami spectra as Shape-DNA of surfaces and solids", Computer-Aided
        Design 38 (2006).
    """
    return basis.evals * basis.area if unit_area else basis.evals


def at_unit_area(basis: Eigenbasis) -> Eigenbasis:
    """The eigenbasis, in float64, that the shape would have if it were scaled to unit area."""
    area = basis.area
    evecs = np.asarray(basis.evecs, dtype=float) * np.sqrt(area)
    return Eigenbasis(np.asarray(basis.evals, dtype=float) * area, evecs, basis.mass / area, basis.connectivity)


def heat_kernel_signature(basis: Eigenbasis, times: Float[np.ndarray, " n"]) -> Float[np.ndarray, "V n"]:
    """(V, n) Σ e^(−λt) φ(x)² / Σ e^(−λt) at n times t, those of the shape at unit area.

    Two shapes are compared at the same times. Of k functions nothing is known before about 1 / (πk), when the highest
    still counts for e⁻⁴.

    Reference:
        Sun, Ovsjanikov and Guibas, "A concise and provably informative multi-scale signature based on heat diffusion",
        Computer Graphics Forum 28 (2009).
    """
    basis = at_unit_area(basis)
    decay = np.exp(-basis.evals[:, None] * times)
    return basis.evecs**2 @ (decay / decay.sum(axis=0))


def wave_bounds(*bases: Eigenbasis) -> tuple[float, float]:
    """The range of log λ, at unit area, that all these shapes have: two shapes are compared at the same energies.

    Raises:
        InputError: fewer than 2 eigenfunctions, or shapes whose spectra have nothing in common.
    """
    for basis in bases:
        _check(basis, 1)
    low = max(np.log(basis.evals[_first(basis)] * basis.area) for basis in bases)
    high = min(np.log(basis.evals[-1] * basis.area) for basis in bases)
    if low > high:
        raise InputError("wave kernels: expected shapes with overlapping spectra; take more eigenfunctions")
    return low, high


def wave_kernel_signature(
    basis: Eigenbasis, n: int = 100, bounds: tuple[float, float] | None = None
) -> Float[np.ndarray, "V n"]:
    """(V, n) Σ g_e(λ) φ(x)² / Σ g_e(λ), the mean probability to meet a particle of energy e at x, for n energies e.

    g_e(λ) = exp(−(e − log λ)² / 2σ²), the energies evenly spaced at a step δ with σ = 7 δ and 2 σ left free on both
    ends of `bounds`. Intrinsic: the two sides of a symmetric shape look the same.

    Args:
        basis: of the shape.
        n: number of energies.
        bounds: of log λ, see `wave_bounds`; None is those of this shape alone.

    Raises:
        InputError: n below 1, or fewer than 2 eigenfunctions.

    Reference:
        Aubry, Schlickewei and Cremers, "The wave kernel signature: a quantum mechanical approach to shape analysis",
        ICCV Workshops (2011).
    """
    return at_unit_area(basis).evecs[:, _first(basis) :] ** 2 @ _bands(basis, n, bounds).T


def wave_kernel_maps(
    basis: Eigenbasis,
    landmarks: Sequence[int] | Int[np.ndarray, " m"],
    n: int = 100,
    bounds: tuple[float, float] | None = None,
) -> Float[np.ndarray, "k m n"]:
    """(k, m, n) the functions Σ g_e(λ) φ(p) φ / Σ g_e(λ) of m landmarks p, in the eigenfunctions at unit area.

    g as in `wave_kernel_signature`. Unlike signatures they tell all points apart, given landmarks off the symmetry.

    Args:
        basis: of the shape.
        landmarks: (m,) vertices.
        n, bounds: of energies, see `wave_kernel_signature`.

    Raises:
        InputError: a landmark that is no vertex, n below 1, or fewer than 2 eigenfunctions.

    Reference:
        Ovsjanikov, Ben-Chen, Solomon, Butscher and Guibas, "Functional maps", ACM Transactions on Graphics 31 (2012).
    """
    landmarks = np.asarray(landmarks)
    wrong = (landmarks < 0) | (landmarks >= len(basis.mass))
    if wrong.any():
        raise InputError(f"landmarks: expected vertices, 0 to {len(basis.mass) - 1}, got {landmarks[wrong][0]}")
    at_landmarks = at_unit_area(basis).evecs[landmarks].T
    maps = np.zeros((basis.k, len(landmarks), n))
    first = _first(basis)
    maps[first:] = at_landmarks[first:, :, None] * _bands(basis, n, bounds).T[:, None]
    return maps


def _bands(basis: Eigenbasis, n: int, bounds: tuple[float, float] | None) -> np.ndarray:
    """(n, k - c) the weights g of the functions but those of frequency zero, each row of sum 1."""
    _check(basis, n)
    low, high = wave_bounds(basis) if bounds is None else bounds
    step = (high - low) / (n + 4 * WIDTH) or 1.0  # one level alone has a band of any width
    energies = low + 2 * WIDTH * step + step * np.arange(n)
    exponent = -((energies[:, None] - np.log(basis.evals[_first(basis) :] * basis.area)) ** 2) / (
        2 * (WIDTH * step) ** 2
    )
    bands = np.exp(exponent - exponent.max(axis=1, keepdims=True))  # a band may lie far from all levels
    return bands / bands.sum(axis=1, keepdims=True)


def _first(basis: Eigenbasis) -> int:
    """The number of functions of frequency zero, one a connected piece."""
    return max(1, int((basis.evals == 0).sum()))


def _check(basis: Eigenbasis, n: int) -> None:
    check_whole("n", n, 1)
    least = _first(basis) + 1
    if basis.k < least:
        raise InputError(f"signatures: expected {least} eigenfunctions or more, got {basis.k}")
