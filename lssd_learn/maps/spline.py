"""A vertex map from landmarks in space: a thin-plate spline brings one shape to the other, matched points refine it.

For rigid shapes of one kind, such as bones: few landmarks say how to lay one upon the other, the surfaces say the rest.
Shapes in different poses need intrinsic maps, such as those of `landmarks.py`.
"""

from dataclasses import dataclass
from typing import cast

import numpy as np
from jaxtyping import Int
from scipy.interpolate import RBFInterpolator

from lssd_learn.errors import InputError, check_whole
from lssd_learn.kdtree import cKDTree
from lssd_learn.shapes import Shape
from lssd_learn.shapes.sampling import farthest_points

# All lengths are in parts of the root mean square distance of the target's points from their mean.
APART = 1e-3  # landmarks nearer than this to another say nothing of their own
TRUST = 0.01  # smoothing at the landmarks
STIFF, SOFT = 0.3, 0.05  # at the matched points, in the first half of the rounds and in the second
FAR = 3.0  # pairs farther apart than so many medians are no pairs
FLAT = 1e-3  # landmarks whose third extent is below this part of the first are in a plane


@dataclass(frozen=True)
class Spline:
    """The choices of `spline_vertices`.

    Attributes:
        rounds: of matching each sampled point with the nearest of the other shape and bending anew.
        samples: points of each shape that are matched.

    Raises:
        InputError: a number out of its range.
    """

    rounds: int = 6
    samples: int = 400

    def __post_init__(self):
        check_whole("maps.rounds", self.rounds, 0)
        check_whole("maps.samples", self.samples, 1)


def spline_vertices(
    source: Shape,
    target: Shape,
    source_landmarks,
    target_landmarks,
    how: Spline = Spline(),  # noqa: B008: frozen
) -> tuple[Int[np.ndarray, " V_target"], Int[np.ndarray, " V_source"]]:
    """For each vertex of the target one of the source (V_target,), and the other way (V_source,).

    Args:
        source, target: meshes or clouds.
        source_landmarks, target_landmarks: (m,) corresponding vertices, four or more, not all in one plane.
        how: the choices.

    Raises:
        InputError: too few landmarks, or all in one plane.

    Reference:
        Bookstein, "Principal warps", IEEE Transactions on Pattern Analysis and Machine Intelligence 11 (1989); matched
        and bent in turn as by Chui and Rangarajan, "A new point matching algorithm for non-rigid registration" (2003).
    """
    centre = target.points.mean(0)
    size = np.sqrt(np.square(target.points - centre).sum(1).mean())
    x, y = (source.points - source.points.mean(0)) / size, (target.points - centre) / size
    a, b = _distinct(x[np.asarray(source_landmarks)], y[np.asarray(target_landmarks)])
    bent = _bend(a, b, np.zeros(len(a)), x)
    some_x, some_y = (farthest_points(points, min(how.samples, len(points))) for points in (x, y))
    tree = cKDTree(y)
    for number in range(how.rounds):
        ahead, there = tree.query(bent[some_x])
        back, here = cKDTree(bent).query(y[some_y])
        near = np.concatenate([ahead <= FAR * np.median(ahead), back <= FAR * np.median(back)])
        start = np.concatenate([x[some_x], x[here]])[near]
        end = np.concatenate([y[there], y[some_y]])[near]
        softness = np.full(len(start), STIFF if 2 * number < how.rounds else SOFT)
        # A point that was matched twice, or is a landmark, counts once: the system would be singular.
        points, first = np.unique(np.concatenate([a, start]), axis=0, return_index=True)
        smoothing = np.concatenate([np.full(len(a), TRUST), softness])[first]
        bent = _bend(points, np.concatenate([b, end])[first], smoothing, x)
    return cKDTree(bent).query(y)[1], tree.query(bent)[1]


def _distinct(a: np.ndarray, b: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The landmarks that are apart from those before them, on both shapes."""
    kept: list[int] = []
    for j in range(len(a)):
        distances = [min(np.linalg.norm(p[j] - p[i]) for p in (a, b)) for i in kept]
        kept += [j] if min(distances, default=np.inf) > APART else []
    for points in (a[kept], b[kept]):
        extents = np.linalg.svd(points - points.mean(0), compute_uv=False) if len(kept) > 3 else np.zeros(3)
        if extents[2] <= FLAT * extents[0]:
            raise InputError(f"maps: expected four landmarks or more that are not in one plane, got {len(kept)}")
    return a[kept], b[kept]


def _bend(source: np.ndarray, target: np.ndarray, smoothing: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Where the spline of least bending takes the points; in space it is made of distances."""
    return RBFInterpolator(source, target, smoothing=cast(float, smoothing), kernel="linear", degree=1)(points)
