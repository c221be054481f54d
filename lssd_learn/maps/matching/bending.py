"""Fifth step of matching: the source is bent onto the target, guided by the map, and points matched where they lie."""

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from lssd_learn.maps.matching.elastic import Elastic
from lssd_learn.maps.matching.prepared import Prepared
from lssd_learn.shapes.normals import normals

STIFFNESSES = (0.05, 0.03, 0.02, 0.01, 0.005, 0.003, 0.002, 0.001)  # of the rounds, at unit area
NORMALS = 0.05  # weight of a unit normal against a distance of √area
SMOOTH = 60  # functions of the first guess of where the source lies


@dataclass(frozen=True, eq=False)
class Bent:
    """The source, bent onto the target.

    Attributes:
        there: (V_target,) for each vertex of the target the vertex of the source.
        back: (V_source,) the other way.
        points, normals: (V_source, 3) of the bent source.
        energy: see `Elastic.energy`.
    """

    there: np.ndarray
    back: np.ndarray
    points: np.ndarray
    normals: np.ndarray
    energy: float


def bent(source: Prepared, target: Prepared, there: np.ndarray, back: np.ndarray) -> Bent:
    """The source bent so that its points lie where the map says, ever less stiffly, and matched anew with what is near.

    Limbs keep their lengths and girths at first, so that a map's scatter and folds are averaged out; what stretch is
    left over large parts is then taken for the difference of two people.

    Args:
        source, target: the two shapes.
        there: (V_target,) for each vertex of the target the vertex of the source.
        back: (V_source,) the other way.
    """
    elastic, functions = Elastic(source), source.basis.evecs[:, :SMOOTH]
    mass, others = source.basis.mass, target.basis.mass
    points = functions @ (functions.T @ (mass[:, None] * target.points[back]))
    for stiffness in STIFFNESSES:
        weights = mass + np.bincount(there, others, minlength=len(mass))
        pulls = [np.bincount(there, others * column, minlength=len(mass)) for column in target.points.T]
        goals = (mass[:, None] * target.points[back] + np.stack(pulls, axis=1)) / weights[:, None]
        points = elastic.fit(goals, weights, stiffness, points)
        energy = elastic.energy(points)
        elastic.learn(points)
        facing = normals(source.shape, points)
        a, b = np.hstack([points, NORMALS * facing]), np.hstack([target.points, NORMALS * target.normals])
        there, back = cKDTree(a).query(b)[1], cKDTree(b).query(a)[1]
    return Bent(there, back, points, facing, energy)
