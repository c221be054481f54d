"""The mathematics of `kernel_machine.py` where there are too many training shapes for the kernel of all pairs.

Functions are then sums over some of the shapes, the centres, that fit all of them: in the features
F = K_nm U E^-½ of K_mm = U E Uᵀ, the kernel of the centres, it is a ridge regression, and with all shapes as centres it
is the machine itself. Neither time nor memory grows faster than n.

Source: Williams & Seeger, "Using the Nyström method to speed up kernel machines", NIPS 2001; as a regression on all
shapes Rudi, Camoriano & Rosasco, "Less is more: Nyström computational regularization", NIPS 2015.
"""

from typing import NamedTuple

import torch
from jaxtyping import Float
from torch import Tensor

from lssd_learn.nets.kernel import gaussian

ROWS = 2048  # shapes at once
NEGLIGIBLE = 1e-12  # part of the largest eigenvalue of the kernel of the centres below which a direction is rounding


class Spectrum(NamedTuple):
    """A ridge regression for every strength: weights of the centres are axes · ((axesᵀ K_mn t) / (values + ν))."""

    values: Float[Tensor, " r"]
    axes: Float[Tensor, "m r"]
    loads: Float[Tensor, " r"]


def spectrum(
    x: Float[Tensor, "n r"], centres: Float[Tensor, "m r"], metric: Float[Tensor, "r r"], target: Float[Tensor, " n"]
) -> Spectrum:
    """Of one output, all n shapes passed through once, a few at a time.

    Args:
        x: (n, r) all training shapes.
        centres: (m, r) some of them.
        metric: (r, r) of the Gaussian.
        target: (n,).
    """
    evals, U = torch.linalg.eigh(gaussian(centres, centres, metric))
    sound = evals > NEGLIGIBLE * evals[-1]
    features = U[:, sound] / evals[sound].sqrt()
    products, loads = x.new_zeros(len(centres), len(centres)), x.new_zeros(len(centres))
    for some, wanted in zip(x.split(ROWS), target.split(ROWS), strict=True):
        kernel = gaussian(some, centres, metric)
        products.addmm_(kernel.T, kernel)
        loads.addmv_(kernel.T, wanted)
    form = features.T @ products @ features
    values, V = torch.linalg.eigh((form + form.T) / 2)
    axes = features @ V
    return Spectrum(values.clamp(min=0), axes, axes.T @ loads)


def weights(
    found: Spectrum, noises: Float[Tensor, " noises"], across: Float[Tensor, "v m"], wanted: Float[Tensor, " v"]
) -> Float[Tensor, " m"]:
    """Weights (m,) of the centres, with the noise whose predictions are nearest to what is wanted.

    Args:
        found: of `spectrum`.
        noises: ν to choose from.
        across: (v, m) kernel of validation shapes and centres.
        wanted: (v,).
    """
    candidates = found.axes @ (found.loads[:, None] / (found.values[:, None] + noises))
    return candidates[:, ((across @ candidates - wanted[:, None]) ** 2).mean(0).argmin()]


def ridges(
    x: Float[Tensor, "n r"],
    targets: Float[Tensor, "n p"],
    others: Float[Tensor, "v r"],
    wanted: Float[Tensor, "v p"],
    noises: Float[Tensor, " noises"],
) -> Float[Tensor, "r p"]:
    """Weights (r, p) of ridges on x, each with the noise best on validation, from the products of its columns."""
    scale = float((x**2).sum() / len(x)) or 1.0  # so that noises mean what they do to a kernel whose diagonal is 1
    values, V = torch.linalg.eigh(x.T @ x / scale)
    loads, seen = V.T @ (x.T @ targets) / scale, others @ V
    found = []
    for load, want in zip(loads.T, wanted.T, strict=True):
        candidates = load[:, None] / (values.clamp(min=0)[:, None] + noises)
        found.append(V @ candidates[:, ((seen @ candidates - want[:, None]) ** 2).mean(0).argmin()])
    return torch.stack(found, dim=1)
