"""Last step of matching: how good the map is, from what can be seen without the truth."""

from dataclasses import astuple, dataclass

import numpy as np

from lssd_learn.maps.matching.bending import Bent, Rough
from lssd_learn.maps.matching.features import Features
from lssd_learn.maps.matching.prepared import Prepared
from lssd_learn.maps.quality import coverage
from lssd_learn.shapes.triangles import triangle_normals

LOOKS = 3  # power of how unlike points look against what bending costs


@dataclass(frozen=True)
class Measures:
    """What tells good maps from bad ones. Lengths are over √area.

    Attributes:
        energy: of bending the source onto the target, see `Elastic.energy`: the mean square strain.
        gap: mean distance of the target's points from the bent source's and the other way.
        facing: one minus the mean cosine between normals there.
        trip: mean distance on the source between a point and where it ends up on the target and back.
        uncovered: share of the source's area whose vertices none of the target's is matched with.
        turned: share of the target's area whose triangles turn over on their way to the source.
        unlike: mean distance of matched points' descriptors, plain and sided.
    """

    energy: float
    gap: float
    facing: float
    trip: float
    uncovered: float
    turned: float
    unlike: float


def measures(source: Prepared, target: Prepared, looks: tuple[Features, Features], found: Bent) -> Measures:
    """Of a map that the source was bent by."""
    mass, others = source.basis.mass, target.basis.mass
    there, back = found.there, found.back
    away = np.linalg.norm(found.points[there] - target.points, axis=1) @ others
    home = np.linalg.norm(found.points - target.points[back], axis=1) @ mass
    same = np.einsum("vx,vx->v", found.normals[there], target.normals) @ others
    trip = np.linalg.norm(source.points[there[back]] - source.points, axis=1) @ mass
    return Measures(
        energy=found.energy,
        gap=float(away + home) / 2,
        facing=float(1 - same),
        trip=float(trip),
        uncovered=1 - coverage(mass, there),
        turned=_turned(source, target, there),
        unlike=float(unlikeness(looks, there, np.arange(len(others))) @ others),
    )


def unlikeness(looks: tuple[Features, Features], there: np.ndarray, points: np.ndarray) -> np.ndarray:
    """(m,) distances between the descriptors of m points of the target and of those of the source they go to."""
    mine, theirs = looks[0].at(there), looks[1].at(points)
    return np.sqrt(((mine.plain - theirs.plain) ** 2 + (mine.sided - theirs.sided) ** 2).sum(axis=1))


def misfit(rough: Rough, source: Prepared, target: Prepared, looks: tuple[Features, Features]) -> float:
    """What tells the best of several rough matches: what they cost in bending, and how unlike matched points look."""
    there = unlikeness(looks, rough.there, target.samples).mean()
    back = unlikeness(looks, source.samples, rough.back).mean()
    return float(rough.energy * ((there + back) / 2) ** LOOKS)


def _turned(source: Prepared, target: Prepared, there: np.ndarray) -> float:
    """The share of the target's area that turns over; triangles that collapse don't."""
    corners = there[target.shape.faces]
    over = np.einsum("fx,fx->f", triangle_normals(source.points[corners]), source.normals[corners].sum(axis=1)) < 0
    areas = target.shape.face_areas
    return float(areas[over].sum() / areas.sum())


# Of a logistic model of "the mean error is below 5 % of √area" on logarithms of the measures.
CONSTANT = 0.0
WEIGHTS = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
TINY = 1e-4  # added before the logarithm


def quality(seen: Measures) -> float:
    """In [0, 1]: the probability that the mean error is below 5 % of √area, as on generated bodies."""
    score = CONSTANT + np.array(WEIGHTS) @ np.log(np.array(astuple(seen)) + TINY)
    return float(1 / (1 + np.exp(-score)))
