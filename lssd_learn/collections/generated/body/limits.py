"""Poses that nobody has named: every joint turned at random within what joints allow.

Limits lie within the ranges of motion of healthy adults (American Academy of Orthopaedic Surgeons, "Joint Motion:
Method of Measuring and Recording"), narrower where limbs would run into the trunk or one another; the rest pose, arms
halfway down, is zero. Axes are those of `poses.py`. A hip or a shoulder turns about two axes at once; knees and elbows
are hinges.
"""

from collections.abc import Mapping

import numpy as np
from scipy.spatial.transform import Rotation

from lssd_learn.collections.generated.body.poses import Angles

# Goes up whenever the same numbers give other poses: it is part of the cache key.
VERSION = 1
FREE = "free"  # what a group "pose" calls them

# Elbows bend about this axis of the left forearm in the rest pose: it moves forward and up.
HINGE = (-np.sqrt(0.5), 0.0, -np.sqrt(0.5))

# Bone → turns one after the other, each an axis and the least and largest angle in degrees. Of the left limbs: right
# ones are their mirror images, with numbers of their own.
TRUNK: Mapping[str, tuple] = {
    "spine03": (((1, 0, 0), -10, 30), ((0, 1, 0), -12, 12), ((0, 0, 1), -15, 15)),
    "spine02": (((1, 0, 0), -8, 20), ((0, 1, 0), -8, 8), ((0, 0, 1), -15, 15)),
    "neck01": (((1, 0, 0), -15, 20), ((0, 1, 0), -12, 12), ((0, 0, 1), -30, 30)),
}
LIMBS: Mapping[str, tuple] = {
    "upperleg01": (((0, 1, 0), -30, 2), ((1, 0, 0), -85, 15)),  # apart, then forward or back
    "lowerleg01": (((1, 0, 0), 0, 100),),
    "upperarm01": (((0, 1, 0), -90, 25), ((0, 0, 1), -50, 25)),  # up or down, then forward or back
    "lowerarm01": ((HINGE, 0, 100),),
}
NUMBERS = sum(len(turns) for turns in TRUNK.values()) + 2 * sum(len(turns) for turns in LIMBS.values())


def free_pose(shares: np.ndarray) -> Angles:
    """The angles of a pose within the limits.

    Args:
        shares: (`NUMBERS`,) in [0, 1], of each angle's range, the least angle first.
    """
    found, left = {}, list(map(float, shares))
    for side, sign, bones in ((None, 1, TRUNK), (".L", 1, LIMBS), (".R", -1, LIMBS)):
        for bone, turns in bones.items():
            rotation = Rotation.identity()
            for axis, least, most in turns:
                angle = np.deg2rad(least + (most - least) * left.pop(0))
                # Of a mirrored turn the angles about y and z change their sign.
                rotation = Rotation.from_rotvec(np.multiply(axis, (1, sign, sign)) * angle) * rotation
            found[bone + (side or "")] = tuple(rotation.as_euler("xyz", degrees=True).tolist())
    return found
