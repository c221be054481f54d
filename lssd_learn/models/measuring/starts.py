"""Where a body begins to be laid on a scan: people in many poses, laid on it by their principal axes."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float

from lssd_learn.kdtree import cKDTree
from lssd_learn.models.measuring.posable import Posable, Pose

AXES = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]])  # the turns that leave principal axes in place


@dataclass(frozen=True, eq=False)
class Start:
    """A person in a pose.

    Attributes:
        pose: the same.
        laid: (N, 3) points of it, from their centre (3,) and along their principal axes (3, 3).
        tree: of these.
    """

    pose: Pose
    laid: Float[np.ndarray, "N 3"]
    axes: Float[np.ndarray, "3 3"]
    centre: Float[np.ndarray, " 3"]
    tree: cKDTree


@dataclass(frozen=True, eq=False)
class Starts:
    """People in many poses.

    Attributes:
        body: some vertices, spread out over it.
        weights: (s, q) of each person, and turns (s, B, 3, 3) of its joints, see `Pose`.
    """

    body: Posable
    weights: Float[np.ndarray, "s q"]
    turns: Float[np.ndarray, "s B 3 3"]

    @cached_property
    def _people(self) -> list[Start]:
        found = []
        for weights, turns in zip(self.weights, self.turns, strict=True):
            pose = self.body.begun(weights, turns)
            laid, axes, centre = on_axes(self.body.lying(pose).points)
            found.append(Start(pose, laid, axes, centre, cKDTree(laid)))
        return found

    def nearest(self, points: Float[np.ndarray, "N 3"], count: int) -> list[Pose]:
        """So many of them, turned and moved onto points all over a scan, the nearest first."""
        laid, axes, centre = on_axes(points)
        ways = [laid * signs for signs in AXES]
        trees = [cKDTree(way) for way in ways]
        away = np.array(
            [
                [
                    np.mean(one.tree.query(way)[0] ** 2) + np.mean(tree.query(one.laid)[0] ** 2)
                    for way, tree in zip(ways, trees, strict=True)
                ]
                for one in self._people
            ]
        )
        found = []
        for place in np.argsort(away, axis=None, kind="stable")[:count]:
            number, way = divmod(int(place), len(AXES))
            one = self._people[number]
            turn = axes * AXES[way] @ one.axes.T
            turns = one.pose.turns.copy()
            turns[0] = turn @ turns[0]
            found.append(Pose(one.pose.weights, turns, turn @ (one.pose.place - one.centre) + centre))
        return found


def on_axes(
    points: Float[np.ndarray, "N 3"],
) -> tuple[Float[np.ndarray, "N 3"], Float[np.ndarray, "3 3"], Float[np.ndarray, " 3"]]:
    """(N, 3) points from their centre and along their principal axes, (3, 3) these axes as columns, the longest first
    and right-handed, and (3,) the centre."""
    centre = points.mean(axis=0)
    axes = np.linalg.eigh((points - centre).T @ (points - centre))[1][:, ::-1].copy()
    axes[:, 2] *= np.linalg.det(axes)
    return (points - centre) @ axes, axes, centre
