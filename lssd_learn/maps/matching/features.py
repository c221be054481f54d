"""Second step of matching: what points of two shapes look like, so that left and right look different."""

from dataclasses import dataclass

import numpy as np

from lssd_learn.maps.matching.prepared import FUNCTIONS, Prepared
from lssd_learn.shapes.descriptors import heat_kernel_signature, wave_bounds, wave_kernel_signature

ENERGIES = 16
TIMES = np.geomspace(0.004, 0.2, 12)  # of heat, at unit area: from what 80 functions can tell to a limb


@dataclass(frozen=True, eq=False)
class Features:
    """Descriptors of the V points of one shape, in units that suit both; see `features`.

    Attributes:
        plain: (V, d) wave kernel signatures; a shape and its mirror image have the same.
        sided: (V, d) of the other sign on the mirror image.
        fine: (V, e) these, and what tells near points apart, in no unit: heat kernel signatures' logarithms and
            curvatures at several scales; compared by `likelihood.details`.
    """

    plain: np.ndarray
    sided: np.ndarray
    fine: np.ndarray

    def at(self, points: np.ndarray) -> "Features":
        """Of some of the points only."""
        return Features(self.plain[points], self.sided[points], self.fine[points])


def features(source: Prepared, target: Prepared) -> tuple[Features, Features]:
    """Descriptors of the points of two shapes.

    The plain ones are signatures w_e, of mean 0 and unit variance, all d together. The sided ones are the brackets
    n · (∇r × ∇w_e), r the reach: on which side of the way out along a limb the signature rises, as seen from outside.
    No isometry that keeps the orientation changes them, and any that reverses it changes their sign: they tell the left
    side of a symmetric shape from the right one, from nothing but the orientation of the triangles.

    Reference:
        The brackets are those of Ren, Poulenard, Wonka and Ovsjanikov, "Continuous and orientation-preserving
        correspondences via functional maps", ACM Transactions on Graphics 37 (2018), used as descriptors.
    """
    bases = [shape.basis.truncate(min(FUNCTIONS, shape.basis.k)) for shape in (source, target)]
    bounds = wave_bounds(*bases)
    plain = [wave_kernel_signature(basis, ENERGIES, bounds) for basis in bases]
    mean, scale = _moments(plain)
    plain = [(w - mean) / scale for w in plain]
    both = zip((source, target), bases, plain, strict=True)
    sided = [brackets(shape, basis.k, shape.reach, w) for shape, basis, w in both]
    _, spread = _moments(sided)
    root = np.sqrt(ENERGIES)
    made = []
    for shape, w, s in zip((source, target), plain, sided, strict=True):
        w, s = w / root, s / (spread * root)
        heat = np.log(heat_kernel_signature(shape.basis, TIMES))
        made.append(Features(w, s, np.hstack([w, s, heat, shape.curvatures]).astype(np.float32)))
    one, other = made
    return one, other


def brackets(shape: Prepared, k: int, f: np.ndarray, others: np.ndarray) -> np.ndarray:
    """(V, d) n · (∇f × ∇g) for the d columns g (V, d), smoothed: their parts in the first k eigenfunctions."""
    a, b, c = shape.shape.faces.T
    along, across = (f[b] - f[a])[:, None], (f[c] - f[a])[:, None]
    over_faces = along * (others[c] - others[a]) - across * (others[b] - others[a])  # twice the integral over each
    corners = np.repeat(over_faces / 6, 3, axis=0)
    flat = shape.shape.faces.ravel()
    integrals = np.stack([np.bincount(flat, column, minlength=len(f)) for column in corners.T], axis=1)
    functions = shape.basis.evecs[:, :k]
    return functions @ (functions.T @ integrals)


def _moments(pair: list[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Mean and deviation (d,) of the columns of both together, each shape counting half."""
    mean = (pair[0].mean(axis=0) + pair[1].mean(axis=0)) / 2
    deviation = np.sqrt((pair[0].var(axis=0) + pair[1].var(axis=0)) / 2)
    return mean, np.where(deviation > 0, deviation, 1)
