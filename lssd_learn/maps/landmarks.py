"""A functional map from a few landmarks that two shapes share."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from lssd_learn.errors import check_whole
from lssd_learn.maps.correspondence import from_correspondence
from lssd_learn.maps.probes import probes
from lssd_learn.maps.zoomout import zoomed_vertices
from lssd_learn.shapes import Eigenbasis
from lssd_learn.shapes.descriptors import at_unit_area


@dataclass(frozen=True)
class Landmarks:
    """The choices of `landmarks`.

    Attributes:
        functions: of the small map.
        refined: functions at the end of ZoomOut; None leaves it out.
        commutativity: weight of commutativity with the Laplacian, see `commuting`.

    Raises:
        InputError: functions below 1.
    """

    functions: int = 30
    refined: int | None = 40
    commutativity: float = 1.0

    def __post_init__(self):
        check_whole("functions", self.functions, 1)


def landmarks(
    source: Eigenbasis,
    target: Eigenbasis,
    source_landmarks: Sequence[int] | Int[np.ndarray, " m"],
    target_landmarks: Sequence[int] | Int[np.ndarray, " m"],
    **choices,
) -> Float[np.ndarray, "k_target k_source"]:
    """C (k_target, k_source), which carries functions on `source` to functions on `target`, from common landmarks.

    A small map that carries wave kernels of the one shape to those of the other, made larger by ZoomOut, made a vertex
    map, made a map of all functions.

    Args:
        source, target: eigenbases.
        source_landmarks, target_landmarks: (m,) corresponding vertices, some of them off the symmetry of the shape.
        choices: see `Landmarks`.

    Raises:
        InputError: landmarks that do not fit, functions below 1.

    Reference:
        Ovsjanikov, Ben-Chen, Solomon, Butscher and Guibas, "Functional maps", ACM Transactions on Graphics 31 (2012).
    """
    vertices = landmark_vertices(source, target, source_landmarks, target_landmarks, Landmarks(**choices))
    return from_correspondence(source, target, vertices)


def landmark_vertices(
    source: Eigenbasis,
    target: Eigenbasis,
    source_landmarks: Sequence[int] | Int[np.ndarray, " m"],
    target_landmarks: Sequence[int] | Int[np.ndarray, " m"],
    how: Landmarks = Landmarks(),  # noqa: B008: frozen
) -> Int[np.ndarray, " V_target"]:
    """(V_target,) for each vertex of the target the vertex of the source: `landmarks` before its last step."""
    s, t = at_unit_area(source), at_unit_area(target)
    A, B = probes(s, t, source_landmarks, target_landmarks)
    n, m = min(how.functions, s.k), min(how.functions, t.k)
    C = commuting(A[:n], B[:m], s.evals[:n], t.evals[:m], how.commutativity)
    return zoomed_vertices(s, t, C, how.refined)


def commuting(
    A: np.ndarray, B: np.ndarray, source_evals: np.ndarray, target_evals: np.ndarray, weight: float
) -> np.ndarray:
    """C (m, n) that minimises ‖CA − B‖² + w Σ_ab Δ_ab C_ab², with Δ_ab = (λ_target,a − λ_source,b)², its maximum 1.

    Constants stay constants: at unit area the first column is that of the identity. Every row is a least squares
    problem of its own, C_a (AAᵀ + w diag Δ_a) = B_a Aᵀ.

    Args:
        A, B: (n, q) and (m, q) coefficients of corresponding functions at unit area.
        source_evals, target_evals: (n,) and (m,), of unit area.
        weight: w.
    """
    gap = (target_evals[:, None] - source_evals) ** 2
    gram = A @ A.T
    C = np.eye(len(B), len(A))
    right = B @ A.T - np.outer(C[:, 0], gram[0])
    if len(A) > 1:
        penalty = np.eye(len(A) - 1) * (weight * gap / gap.max())[:, None, 1:]
        C[:, 1:] = np.linalg.solve(gram[1:, 1:] + penalty, right[:, 1:, None])[..., 0]
    return C
