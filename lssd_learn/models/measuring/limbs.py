"""Limbs that lie wrong are tried as others hold theirs: closest points do not turn an arm that lies on the trunk."""

from dataclasses import replace

import numpy as np
from jaxtyping import Float, Int
from scipy.spatial.transform import Rotation

from lssd_learn.kdtree import cKDTree
from lssd_learn.models.measuring.posable import Posable, Pose

FAR, FARTHER = 0.1, 0.3  # metres: what is farther off counts as much; the second where limbs are looked for
LONG = 3  # joints of a limb, at least
SOME = 500  # points of a scan that are looked at
NUDGES, NUDGED = 60, 0.4  # tries around the best of others, every joint turned by so many radians


def apart(
    points: Float[np.ndarray, "n 3"], surface: Float[np.ndarray, "m 3"], tree: cKDTree, far: float = FAR
) -> float:
    """Mean squares of how far points of a body and of a scan are from one another, both ways, and `tree` of these."""
    ways = (cKDTree(points).query(surface[:SOME])[0], tree.query(points)[0])
    return float(sum(np.mean(np.minimum(way, far) ** 2) for way in ways))


def limbs(body: Posable) -> list[Int[np.ndarray, " j"]]:
    """Joints one after the other, where several hang from one: those of each arm and leg. A head is no limb: it would
    reach for a hand that nothing lies on."""
    hanging = np.bincount(body.parents[1:], minlength=len(body.parents))
    found = []
    for joint in range(1, len(body.parents)):
        chain = np.flatnonzero(body.below[joint])
        if hanging[body.parents[joint]] > 1 and (hanging[chain] <= 1).all() and len(chain) >= LONG:
            found.append(chain)
    return found


def rearranged(
    body: Posable,
    pose: Pose,
    turns: Float[np.ndarray, "s B 3 3"],
    surface: Float[np.ndarray, "m 3"],
    tree: cKDTree,
) -> Pose:
    """The same, but for limbs that lie nearer to a scan as one of `turns` has them: one limb after the other.

    Args:
        body: a few vertices, spread out over it.
        surface: all over the scan, and tree of it.
    """
    least = apart(body.lying(pose).points, surface, tree, FARTHER)
    rng = np.random.default_rng(0)
    for limb in limbs(body):
        spun = Rotation.from_rotvec(NUDGED * rng.normal(size=(NUDGES * len(limb), 3))).as_matrix()
        for nudged in (False, True):
            held = pose.turns
            ways = spun.reshape(NUDGES, len(limb), 3, 3) @ held[limb] if nudged else turns[:, limb]
            for way in ways:
                tried = held.copy()
                tried[limb] = way
                away = apart(body.lying(replace(pose, turns=tried)).points, surface, tree, FARTHER)
                if away < least:
                    least, pose = away, replace(pose, turns=tried)
    return pose


def about_face(body: Posable, pose: Pose) -> Pose:
    """The same, facing the other way, where it stands."""
    points = body.lying(pose).points
    turns = pose.turns.copy()
    turns[0] = turns[0] @ np.diag([-1.0, -1.0, 1.0])
    other = replace(pose, turns=turns)
    return replace(other, place=pose.place + points.mean(axis=0) - body.lying(other).points.mean(axis=0))
