"""How a shape lies in space, as its eigenfunctions see it: small matrices that rigid motions leave, or only turn.

V² distances between its vertices go into the form below; expanded, they are sums over the V vertices.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float


@dataclass(frozen=True, eq=False)
class Moments:
    """Moments of the coordinates of a shape in k of its eigenfunctions.

    Attributes:
        form: (k, k) E, see `moments`; in (unit of length)⁴, since an eigenfunction has 1 / (unit of length).
        coordinates: (k, 3) ΦᵀM(X − c), the coordinate functions about the centre of mass; in (unit of length)².
    """

    form: Float[np.ndarray, "k k"]
    coordinates: Float[np.ndarray, "k 3"]

    def truncate(self, k: int) -> "Moments":
        """Those in the first k functions."""
        return Moments(self.form[:k, :k], self.coordinates[:k])


def moments(
    vertices: Float[np.ndarray, "V 3"], mass: Float[np.ndarray, " V"], evecs: Float[np.ndarray, "V k"]
) -> Moments:
    """The form E(f, g) = ½ Σ_ab m_a m_b ‖x_a − x_b‖² (f_a − f_b)(g_a − g_b) in functions Φ, and their coordinates.

    With x about the centre of mass, q = ‖x‖², A = Σ m and Q = Σ m q, this is

        E = Φᵀ diag(m (A q + Q)) Φ − ΦᵀMq (ΦᵀM1)ᵀ − ΦᵀM1 (ΦᵀMq)ᵀ + 2 ΦᵀMX (ΦᵀMX)ᵀ

    which takes V k² operations. It is positive semi-definite, its null function is the constant, and on functions of
    mean zero it is at least Q∫f²: as well conditioned as (A max q + 3Q) / Q.

    Args:
        vertices: X (V, 3), of a mesh or a cloud.
        mass: M (V,).
        evecs: Φ (V, k), any functions.

    Reference:
        Huang, Rakotosaona, Achlioptas, Guibas and Ovsjanikov, "OperatorNet: recovering 3D shapes from difference
        operators", ICCV (2019), whose extrinsic inner product this is.
    """
    Phi, mass = np.asarray(evecs, dtype=float), np.asarray(mass, dtype=float)
    area = mass.sum()
    X = vertices - vertices.mean(axis=0)  # first, for digits: shapes may lie far from zero
    X = X - mass @ X / area
    q = np.square(X).sum(axis=1)
    weighted = Phi.T * mass
    first, square, coordinates = weighted.sum(axis=1), weighted @ q, weighted @ X
    form = (weighted * (area * q + mass @ q)) @ Phi + 2 * coordinates @ coordinates.T
    form -= np.outer(square, first) + np.outer(first, square)
    return Moments((form + form.T) / 2, coordinates)
