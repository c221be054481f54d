"""Fourth step of matching: the source is bent onto the target, guided by the map, and points matched where they lie."""

from dataclasses import dataclass

import numpy as np

from lssd_learn.kdtree import cKDTree
from lssd_learn.maps.matching.elastic import TURNS
from lssd_learn.maps.matching.features import Features
from lssd_learn.maps.matching.lattice import Lattice, mesh_elastic
from lssd_learn.maps.matching.likelihood import drawn
from lssd_learn.maps.matching.prepared import Prepared
from lssd_learn.maps.matching.spectral import fitted
from lssd_learn.shapes.normals import normals

# Stiffness of each round at unit area: on the nets, and on all vertices with their looks.
COARSE = ((0.2, 0.2, 0.1, 0.1, 0.1, 0.05, 0.05, 0.05), (0.05, 0.05, 0.03, 0.03, 0.02, 0.02, 0.01, 0.01))
FIRM, ROUNDS = 0.02, 8  # of the finer net, where looks tell
FINE = (0.02, 0.01)
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


@dataclass(frozen=True, eq=False)
class Rough:
    """The source, bent by a net of few points.

    Attributes:
        there, back: vertices of the source that the target's samples are matched with, and the other way.
        points: (V_source, 3) of the bent source.
        energy: of the net; infinite before there was one.
    """

    there: np.ndarray
    back: np.ndarray
    points: np.ndarray
    energy: float


def laid(source: Prepared, target: Prepared, there: np.ndarray, back: np.ndarray) -> Rough:
    """Where a match of the samples says that the source lies, smoothed.

    Args:
        source, target: the two shapes.
        there: (n_target,) vertices of the source that the target's samples are matched with.
        back: (n_source,) the other way.
    """
    functions = source.basis.evecs[:, :SMOOTH]
    points = functions @ fitted(functions[source.samples], target.points[back])
    return Rough(there, back, points, np.inf)


def roughly(nets: list[Lattice], level: int, target: Prepared, start: Rough) -> Rough:
    """The source bent by a net so that its points lie where they are matched, ever less stiffly.

    Limbs keep their lengths and girths at first, so that a map's scatter and folds are averaged out; what stretch is
    left over large parts is then taken for the difference of two people. Nets of few points settle quickly.

    Args:
        nets: of the source, coarse to fine.
        level: which of them.
        target: the other shape.
        start: from where.
    """
    net = nets[level]
    source, elastic = net.shape, net.elastic()
    s, t, there, back, points = source.samples, target.samples, start.there, start.back, start.points
    b = np.hstack([target.points, NORMALS * target.normals])[t]
    tree, knots, bending = cKDTree(b), points[net.knots], False
    for stiffness in COARSE[level]:
        ours = np.concatenate([s, there])
        wanted = np.concatenate([target.points[back], target.points[t]])
        shares = np.repeat([1 / len(s), 1 / len(t)], [len(s), len(t)])
        weights = np.bincount(net.cell[ours], shares, minlength=len(knots))
        now = net.followed(elastic, knots, ours) if bending else points[ours]
        solve = elastic.factorised(weights, stiffness)
        for _ in range(TURNS):
            pull = _sums(net.cell[ours], shares[:, None] * (wanted - now), len(knots))
            knots = elastic.turn(solve, knots + pull / weights[:, None], weights, stiffness, knots)
            now = net.followed(elastic, knots, ours)
        energy, bending = elastic.energy(knots), True
        elastic.learn(knots)
        place = net.followed(elastic, knots, s)
        a = np.hstack([place, NORMALS * net.facing(elastic, s)])
        there, back = s[cKDTree(a).query(b)[1]], t[tree.query(a)[1]]
    return Rough(there, back, net.followed(elastic, knots), energy)


def told(net: Lattice, target: Prepared, looks: tuple[Features, Features], start: Rough) -> Rough:
    """The source bent by a net so that each sample lies where its likely partners do on the average.

    See `likelihood`: closest points alone leave a limb free to slide along its length, and what a point looks like does
    not.
    """
    source, elastic, knots = net.shape, net.elastic(), start.points[net.knots]
    elastic.settle(knots)
    s, t, place = source.samples, target.samples, start.points[source.samples]
    there, back = closest(place, net.facing(elastic, s), target.points[t], target.normals[t])
    fine, shares = (looks[0].fine[s], looks[1].fine[t]), (np.full(len(s), 1 / len(s)), np.full(len(t), 1 / len(t)))
    goals = target.points[t], target.normals[t]
    for _ in range(ROUNDS):
        pulls, wanted, there, back = drawn((place, net.facing(elastic, s)), goals, fine, (there, back), shares)
        weights = np.bincount(net.cell[s], pulls, minlength=len(knots))
        solve = elastic.factorised(weights, FIRM)
        for _ in range(TURNS):
            pull = _sums(net.cell[s], pulls[:, None] * (wanted - place), len(knots))
            knots = elastic.turn(solve, knots + pull / weights[:, None], weights, FIRM, knots)
            place = net.followed(elastic, knots, s)
        energy = elastic.energy(knots)
        elastic.learn(knots)
    return Rough(s[there], t[back], net.followed(elastic, knots), energy)


def bent(source: Prepared, target: Prepared, looks: tuple[Features, Features], start: Rough) -> Bent:
    """The source bent onto the target, all its vertices, from where nets have brought it, as `told`."""
    elastic, points = mesh_elastic(source), start.points
    elastic.settle(points)
    facing = normals(source.shape, points)
    there, back = closest(points, facing, target.points, target.normals)
    goals, fine = (target.points, target.normals), (looks[0].fine, looks[1].fine)
    masses = source.basis.mass, target.basis.mass
    for stiffness in FINE:
        weights, places, there, back = drawn((points, facing), goals, fine, (there, back), masses)
        points = elastic.fit(places, weights, stiffness, points)
        energy = elastic.energy(points)
        elastic.learn(points)
        facing = normals(source.shape, points)
    there, back = closest(points, facing, target.points, target.normals)
    return Bent(there, back, points, facing, energy)


def closest(
    points: np.ndarray, facing: np.ndarray, goals: np.ndarray, outward: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Of n points (n, 3) at unit area and their normals the nearest to each of m others, (m,), and the other way, (n,).

    In place and normal: what is near but faces another way is not meant.
    """
    a, b = np.hstack([points, NORMALS * facing]), np.hstack([goals, NORMALS * outward])
    return cKDTree(a).query(b)[1], cKDTree(b).query(a)[1]


def _sums(where: np.ndarray, vectors: np.ndarray, count: int) -> np.ndarray:
    """(count, 3) sums of vectors (m, 3) by where (m,)."""
    return np.stack([np.bincount(where, column, minlength=count) for column in vectors.T], axis=1)
