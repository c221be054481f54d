"""A functional map between two shapes of which nothing in common is known: matching of their heat kernels."""

from dataclasses import dataclass
from typing import cast

import numpy as np
from jaxtyping import Float, Int
from scipy.optimize import linear_sum_assignment
from scipy.sparse import csr_array

from lssd_learn.errors import check_positive, check_whole
from lssd_learn.maps.correspondence import from_correspondence
from lssd_learn.maps.probes import ENERGIES
from lssd_learn.maps.registration import from_near
from lssd_learn.maps.registration import registered as bent_onto
from lssd_learn.maps.zoomout import zoomed_vertices
from lssd_learn.shapes import Eigenbasis, PointCloud, Shape
from lssd_learn.shapes.descriptors import at_unit_area, wave_bounds, wave_kernel_signature
from lssd_learn.shapes.sampling import spread

BENDS = 80  # functions of the last round of bending
TIMES = (0.026, 0.0005)  # of the first and the last heat kernel, at unit area: theirs


@dataclass(frozen=True, eq=False)
class Matched:
    """n corresponding points of two shapes.

    Attributes:
        source, target: (n, V_source) and (n, V_target), sparse: row i takes values at the vertices to those at point i.
    """

    source: csr_array
    target: csr_array

    def reversed(self) -> "Matched":
        """The same points, source and target exchanged."""
        return Matched(self.target, self.source)


@dataclass(frozen=True)
class KernelMatching:
    """The choices of `kernel_matching`.

    Attributes:
        samples: n; of a cloud at most its points. The time grows with its cube: 0.1 s an assignment at 1,000.
        steps: assignments but the first.
        extrinsic: weight of the coordinates, centred and scaled to unit variance as the signatures are; 0 leaves them
            out, and nothing tells left from right then.
        smoothness: λ, for descriptors of unit variance (theirs have d entries each of that, and λ a factor d).
        functions: of the dense map; less than a third of the samples keeps it well determined.
        refined: functions at the end of a ZoomOut, which isometric shapes gain from and bodies of different build lose
            from; None leaves it out.
        registered: rounds of `registration.registered`; 0 leaves it out.
        seed: of the points.

    Raises:
        InputError: a number out of its range.
    """

    samples: int = 300
    steps: int = 8
    extrinsic: float = 1.0
    smoothness: float = 1.0
    functions: int = 30
    refined: int | None = None
    registered: int = 12
    seed: int = 0

    def __post_init__(self):
        check_whole("samples", self.samples, 2)
        check_whole("steps", self.steps, 1)
        check_positive("smoothness", self.smoothness)
        check_whole("functions", self.functions, 1)
        check_whole("registered", self.registered, 0)


def kernel_matching(
    source: Eigenbasis, target: Eigenbasis, source_shape: Shape, target_shape: Shape, **choices
) -> Float[np.ndarray, "k_target k_source"]:
    """C (k_target, k_source), which carries functions on `source` to functions on `target`.

    Points spread over both shapes are matched one to one (`match`), the match is made dense (`densified`) and the one
    shape is bent onto the other (`registration.registered`).

    Args:
        source, target: eigenbases.
        source_shape, target_shape: their shapes. Where `extrinsic` counts, both stand upright and face the same way.
        choices: see `KernelMatching`.

    Raises:
        InputError: a number out of its range.
    """
    there, _ = matched_vertices(source, target, source_shape, target_shape, KernelMatching(**choices))
    return from_correspondence(source, target, there)


def matched_vertices(
    source: Eigenbasis, target: Eigenbasis, source_shape: Shape, target_shape: Shape, how: KernelMatching
) -> tuple[Int[np.ndarray, " V_target"], Int[np.ndarray, " V_source"]]:
    """`kernel_matching` before its last step, both ways: (V_target,) vertices of the source, (V_source,) of the target.

    Args:
        source, target, source_shape, target_shape: the two shapes.
        how: the choices.
    """
    points = match(source, target, source_shape, target_shape, how)
    there = densified(source, target, points, how.functions, how.refined)
    back = densified(target, source, points.reversed(), how.functions, how.refined)
    if not how.registered:
        return there, back
    return bent_onto(source, target, source_shape, target_shape, there, back, from_near(how.registered, BENDS))


def match(
    source: Eigenbasis, target: Eigenbasis, source_shape: Shape, target_shape: Shape, how: KernelMatching
) -> Matched:
    """A one-to-one match P of n points spread over the two shapes, each step a linear assignment:

        P ← argmax_P ⟨P, F₁ + (λ/n) K_X P' K_Yᵀ⟩,  K = Φ e^(−tΛ) Φᵀ,

    P' the match before, t falling from .026 to .0005 at unit area. F₁ are inner products of point descriptors: wave
    kernel signatures and, against mirrored matches that these cannot see, coordinates. One to one matches carry area to
    area: where shapes differ in their proportions the map is off by what that costs.

    Args:
        source, target, source_shape, target_shape: the two shapes.
        how: samples, steps, extrinsic, smoothness and seed count.

    Reference:
        Lähner, Vestner, Boyarski, Litany, Slossberg, Remez, Rodolà, Bronstein, Bronstein, Kimmel and Cremers,
        "Efficient deformable shape correspondence via kernel matching", 3DV (2017), arXiv 1707.08991.
    """
    samples = min([how.samples] + [len(s.points) for s in (source_shape, target_shape) if isinstance(s, PointCloud)])
    rng = np.random.default_rng(how.seed)
    on_source, on_target = spread(source_shape, samples, rng), spread(target_shape, samples, rng)
    s, t = at_unit_area(source), at_unit_area(target)
    bounds = wave_bounds(s, t)
    x, y = (W @ wave_kernel_signature(basis, ENERGIES, bounds) for W, basis in ((on_source, s), (on_target, t)))
    x, y = _standard(x, y)
    F = x @ y.T
    if how.extrinsic:
        x, y = (_centred(W @ shape.vertices) for W, shape in ((on_source, source_shape), (on_target, target_shape)))
        F += how.extrinsic**2 * x @ y.T

    X, Y = on_source @ s.evecs, on_target @ t.evecs
    rows, columns = linear_sum_assignment(F, maximize=True)
    for time in np.geomspace(*TIMES, how.steps):
        smoothed = X * np.exp(-time * s.evals) @ (X[rows].T @ Y[columns]) @ (Y * np.exp(-time * t.evals)).T
        rows, columns = linear_sum_assignment(F + how.smoothness / samples * smoothed, maximize=True)
    return Matched(on_source[rows], on_target[columns])


def densified(
    source: Eigenbasis, target: Eigenbasis, points: Matched, functions: int = 30, refined: int | None = None
) -> Int[np.ndarray, " V_target"]:
    """(V_target,) for each vertex of the target the vertex of the source, from n corresponding points.

    The functional map of the points, least squares of Φ_target C = Φ_source at them, is made a vertex map.

    Args:
        source, target: eigenbases.
        points: see `match`.
        functions, refined: see `KernelMatching`.
    """
    n = max(1, min(functions, source.k, target.k, cast(tuple[int, int], points.source.shape)[0] // 3))
    x, y = points.source @ source.evecs[:, :n], points.target @ target.evecs[:, :n]
    return zoomed_vertices(source, target, np.linalg.lstsq(y, x)[0], refined)


def _standard(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Descriptors (n, d) of two shapes with mean 0 and, all d together, variance 1 over both."""
    both = np.concatenate([x, y])
    mean, deviation = both.mean(axis=0), both.std(axis=0)
    scale = np.where(deviation > 0, deviation, 1) * np.sqrt(both.shape[1])
    return (x - mean) / scale, (y - mean) / scale


def _centred(points: np.ndarray) -> np.ndarray:
    """(n, 3) with their mean at the origin and a mean square distance of 1 from it."""
    points = points - points.mean(axis=0)
    return points / np.sqrt((points**2).sum(axis=1).mean())
