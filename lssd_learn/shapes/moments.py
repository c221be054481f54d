"""How a shape lies in space, as its eigenfunctions see it: small matrices that rigid motions leave, or only turn.

V² distances between its vertices go into the form below; expanded, they are sums over the V vertices.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float


@dataclass(frozen=True, eq=False)
class Moments:
    """Moments of the coordinates of a shape in k of its eigenfunctions.

    Attributes:
        form: (k, k) E, see `pair_form`; in 1 / (unit of length)², since an eigenfunction has 1 / (unit of length).
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
    """The form of all pairs of points, see `pair_form`, and the coordinates, in functions Φ.

    Args:
        vertices: X (V, 3), of a mesh or a cloud.
        mass: M (V,).
        evecs: Φ (V, k), any functions.
    """
    return Moments(*pair_form(vertices, np.asarray(mass, dtype=float), np.asarray(evecs, dtype=float)))


def pair_form(X: Any, mass: Any, Phi: Any) -> tuple[Any, Any]:
    """E(f, g) = Σ_ab w_ab (f_a − f_b)(g_a − g_b) / Σ_ab w_ab in functions Φ (k, k), and ΦᵀM(X − c) (k, 3).

    A mean over all pairs of points, w_ab = m_a m_b ‖x_a − x_b‖². With the parts of the area μ = M / Σ m, x about the
    centre of mass, q = ‖x‖² and Q = Σ μ q, it is

        Q E = Φᵀ diag(μ (q + Q)) Φ − Φᵀμq (Φᵀμ)ᵀ − Φᵀμ (Φᵀμq)ᵀ + 2 ΦᵀμX (ΦᵀμX)ᵀ

    which takes V k² operations. It is positive semi-definite, its null function is the constant, and on functions of
    mean zero it lies between 1 and 3 + max q / Q times Σ μ f². Neither rigid motions nor sizes change it.

    Args:
        X, mass, Phi: (V, 3), (V,), (V, k); all three arrays or all three tensors, through which gradients go.

    Reference:
        Huang, Rakotosaona, Achlioptas, Guibas and Ovsjanikov, "OperatorNet: recovering 3D shapes from difference
        operators", ICCV (2019). Theirs is ½ Σ w_ab (f_a − f_b)(g_a − g_b), which grows as the sixth power of sizes.
    """
    weights, rest, coordinates = pair_parts(X, mass, Phi)
    form = (weights[:, None] * Phi).T @ Phi + rest
    return (form + form.T) / 2, coordinates


def pair_parts(X: Any, mass: Any, Phi: Any) -> tuple[Any, Any, Any]:
    """What `pair_form` is made of: w (V,) and R (k, k) with E = Φᵀ diag(w) Φ + R, and ΦᵀM(X − c) (k, 3)."""
    area = mass.sum()
    X = X - X.mean(0)  # first, for digits: shapes may lie far from zero
    X = X - mass @ X / area
    q, parts = (X * X).sum(1), mass / area
    Q = parts @ q
    first, square, coordinates = Phi.T @ parts, Phi.T @ (parts * q), Phi.T @ (parts[:, None] * X)
    mixed = square[:, None] * first
    return parts * (q + Q) / Q, (2 * coordinates @ coordinates.T - mixed - mixed.T) / Q, area * coordinates
