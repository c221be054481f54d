"""Last step of matching: how good the map is, from what can be seen without the truth."""

from dataclasses import dataclass

import numpy as np
from scipy.special import expit

from lssd_learn.maps.matching.bending import Bent
from lssd_learn.maps.matching.features import Features
from lssd_learn.maps.matching.prepared import Prepared
from lssd_learn.maps.quality import coverage, turned_over

ALONE = 3.0  # lead of a map without a rival


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
        turned=turned_over(source.shape, target.shape, there, source.normals),
        unlike=float(unlikeness(looks, there, np.arange(len(others))) @ others),
    )


def unlikeness(looks: tuple[Features, Features], there: np.ndarray, points: np.ndarray) -> np.ndarray:
    """(m,) distances between the descriptors of m points of the target and of those of the source they go to."""
    mine, theirs = looks[0].at(there), looks[1].at(points)
    return np.sqrt(((mine.plain - theirs.plain) ** 2 + (mine.sided - theirs.sided) ** 2).sum(axis=1))


# All from `calibrate.py`: weights of logarithms of the measures, and what score and lead are worth in the quality.
WEIGHTS = {"energy": -1.91, "trip": -2.72, "unlike": -5.69, "facing": -8.58}
LEVEL, STEEP, LEAD, TELLING = 46.782, 0.964, 0.894, 1.284
TINY = 1e-4  # added before the logarithm
ALIKE = 0.05  # mean distance, over √area, below which two maps are one


def score(seen: Measures) -> float:
    """The higher the better."""
    return float(sum(weight * np.log(getattr(seen, name) + TINY) for name, weight in WEIGHTS.items()))


def quality(reached: float, lead: float) -> float:
    """How likely a map is right, in [0, 1]: it has to do well, and clearly better than the best that differs from it.

    Neither makes up for the other. Between shapes of two kinds one wrong map may be much better than all others; and of
    two maps that are the mirror images of each other both do well.

    Args:
        reached: its score.
        lead: over the other's.
    """
    return float(expit(STEEP * (reached - LEVEL)) * expit(TELLING * (lead - LEAD)))


def chosen(source: Prepared, found: list[tuple[Bent, Measures]]) -> tuple[Bent, Measures, float]:
    """The best of several maps and its quality in [0, 1].

    That is the probability that the mean error is below 5 % of √area, see `quality`. Shapes have symmetries: the best
    map is compared with the best that differs.
    """
    scores = np.array([score(seen) for _, seen in found])
    best = int(scores.argmax())
    way, seen = found[best]
    places = source.points[way.there]
    unlike = [n for n, (other, _) in enumerate(found)
              if np.linalg.norm(source.points[other.there] - places, axis=1).mean() > ALIKE]  # fmt: skip
    lead = scores[best] - max(scores[unlike], default=scores[best] - ALONE)
    return way, seen, quality(scores[best], lead)
