"""A pair of functional maps, one each way, that are adjoint to each other as those of an isometry are."""

from collections.abc import Callable, Sequence
from typing import cast

import numpy as np
from jaxtyping import Float, Int
from scipy.sparse.linalg import LinearOperator, cg

from lssd_learn.maps.probes import probes
from lssd_learn.shapes import Eigenbasis
from lssd_learn.shapes.descriptors import at_unit_area

TOLERANCE = 1e-10  # of the residual, relative
MOST = 5000  # iterations


def adjoint(
    source: Eigenbasis,
    target: Eigenbasis,
    source_landmarks: Sequence[int] | Int[np.ndarray, " m"] = (),
    target_landmarks: Sequence[int] | Int[np.ndarray, " m"] = (),
    descriptors: float = 0.5,
    commutativity: float = 1e-3,
    area: float = 500.0,
    conformal: float = 4.5e-7,
) -> tuple[Float[np.ndarray, "k_target k_source"], Float[np.ndarray, "k_source k_target"]]:
    """(C₁ (k_target, k_source), C₂ (k_source, k_target)), from source to target and back.

    Minimises, at unit area and with the constant functions carried exactly,

        a/2 (‖C₁A − B‖² + ‖C₂B − A‖²) + c/2 Σ (Δ∘C₁² + Δᵀ∘C₂²) + ε₁/2 ‖C₁ − C₂ᵀ‖² + ε₂/2 ‖Λₜ C₁ − C₂ᵀ Λₛ‖²

    with A and B corresponding functions (`probes`) and Δ_ab = (λ_target,a − λ_source,b)², divided by its ‖Δ‖². Maps
    of an isometry are adjoint in the inner products of areas (ε₁) and of gradients (ε₂). Not refined: `zoomout` does.

    Args:
        source, target: eigenbases; all their functions are mapped.
        source_landmarks, target_landmarks: corresponding vertices; without, a symmetric shape may be mapped mirrored.
        descriptors, commutativity, area, conformal: a, c, ε₁, ε₂: theirs (a = .1 for each of the five functions they
            take of a kernel, which here is for all of its functions together). ε₂ is that of unit area.

    Raises:
        InputError: landmarks that do not fit.
        ArithmeticError: the iteration does not converge.

    Reference:
        Huang and Ovsjanikov, "Adjoint map representation for shape analysis and matching", Computer Graphics Forum 36
        (2017); the constants are those of the code they published.
    """
    s, t = at_unit_area(source), at_unit_area(target)
    A, B = probes(s, t, source_landmarks, target_landmarks)
    C1, C2 = _minimise(A, B, s, t, (descriptors, commutativity, area, conformal))
    scale = np.sqrt(target.area / source.area)
    return C1 * scale, C2 / scale


def _minimise(
    A: np.ndarray, B: np.ndarray, s: Eigenbasis, t: Eigenbasis, weights: tuple[float, float, float, float]
) -> tuple[np.ndarray, np.ndarray]:
    """C₁ and C₂ at unit area, by conjugate gradients on the columns behind the first.

    The entries (a, b) of C₁ and (b, a) of C₂ are tied together far more strongly than to any other: the inverses of
    these 2 × 2 blocks precondition the iteration.
    """
    a, c, e1, e2 = weights
    Ls, Lt = s.evals, t.evals
    gram_A, gram_B = a * A @ A.T, a * B @ B.T
    D = (Lt[:, None] - Ls) ** 2
    D *= c / (D**2).sum()
    own = D + e1
    tie = e1 + e2 * np.outer(Lt, Ls)
    sizes = (t.k, s.k)

    def gradient(C1: np.ndarray, C2: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Of the quadratic part of the energy."""
        return (
            C1 @ gram_A + (own + e2 * Lt[:, None] ** 2) * C1 - tie * C2.T,
            C2 @ gram_B + (own.T + e2 * Ls[:, None] ** 2) * C2 - tie.T * C1.T,
        )

    def join(C1: np.ndarray, C2: np.ndarray) -> np.ndarray:
        return np.concatenate([C1[:, 1:].ravel(), C2[:, 1:].ravel()])

    def split(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        C1, C2 = np.zeros(sizes), np.zeros(sizes[::-1])
        count = sizes[0] * (sizes[1] - 1)
        C1[:, 1:], C2[:, 1:] = x[:count].reshape(sizes[0], -1), x[count:].reshape(sizes[1], -1)
        return C1, C2

    first1, first2 = np.zeros(sizes), np.zeros(sizes[::-1])
    # Constants go to constants, whatever signs the eigenfunctions have.
    first1[0, 0] = first2[0, 0] = np.sign(s.evecs[0, 0] * t.evecs[0, 0])
    linear1, linear2 = gradient(first1, first2)
    right = join(a * B @ A.T - linear1, a * A @ B.T - linear2)

    diagonal1 = own + e2 * Lt[:, None] ** 2 + np.diag(gram_A)
    diagonal2 = own + e2 * Ls**2 + np.diag(gram_B)[:, None]
    # Fixed entries are not tied to anything.
    free = np.ones(sizes)
    free[0], free[:, 0] = 0, 0
    loose = tie * free
    determinant = diagonal1 * diagonal2 - loose**2

    def precondition(x: np.ndarray) -> np.ndarray:
        C1, C2 = split(x)
        return join((diagonal2 * C1 + loose * C2.T) / determinant, ((diagonal1 * C2.T + loose * C1) / determinant).T)

    shape = (len(right), len(right))
    linear = cast(Callable[..., LinearOperator], LinearOperator)  # its own signature is not what it takes
    apply = linear(shape, lambda x: join(*gradient(*split(x))), dtype=float)
    x, failed = cg(apply, right, rtol=TOLERANCE, maxiter=MOST, M=linear(shape, precondition, dtype=float))
    if failed:
        raise ArithmeticError(f"adjoint: conjugate gradients did not converge in {MOST} iterations")
    C1, C2 = split(x)
    return C1 + first1, C2 + first2
