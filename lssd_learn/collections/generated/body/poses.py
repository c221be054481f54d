"""The eight poses the generated bodies stand in: plain data, what lies between them, and the rotations it stands for.

`../bodies.py` gives body i the pose i mod 8, or one between two; `model.py` turns the rotations into bone transforms.
Every rotation is about the world axes of the rest pose (x from the body's right to its left, y from front to back, z
up), in degrees, and carries along the bones that hang from it. L and R are the body's own left and right.
"""

from collections.abc import Mapping, Sequence

import numpy as np
from scipy.spatial.transform import Rotation

from lssd_learn.errors import InputError

# Bone → angles about x, y and z.
Angles = Mapping[str, Sequence[float]]

POSES: dict[str, Angles] = {
    "rest": {},
    "arms_down": {"upperarm01.L": (0, 35, 0), "upperarm01.R": (0, -35, 0)},
    "t_pose": {"upperarm01.L": (0, -40, 0), "upperarm01.R": (0, 40, 0)},
    "sitting": {
        "upperleg01.L": (-80, 0, 0),
        "upperleg01.R": (-80, 0, 0),
        "lowerleg01.L": (80, 0, 0),
        "lowerleg01.R": (80, 0, 0),
    },
    "knee_up": {"upperleg01.L": (-70, 0, 0), "lowerleg01.L": (70, 0, 0)},
    "stride": {
        "upperleg01.L": (-35, 0, 0),
        "upperleg01.R": (30, 0, 0),
        "lowerleg01.R": (25, 0, 0),
        "upperarm01.L": (25, 30, 0),
        "upperarm01.R": (-25, -30, 0),
    },
    "bend": {"spine03": (40, 0, 0), "spine02": (25, 0, 0)},
    "reach": {
        "upperarm01.L": (0, -100, 0),
        "spine03": (0, 0, 25),
        "spine02": (0, -12, 0),
        "lowerarm01.R": (0, 0, -60),
    },
}

POSE_NAMES = tuple(POSES)

# Every bone that some pose turns: what jitter turns, about all three axes, in every pose.
JOINTS = tuple(dict.fromkeys(bone for angles in POSES.values() for bone in angles))


def pose_name(pose: str | int) -> str:
    """The name of a pose given by name or by its place in `POSE_NAMES`.

    Raises:
        InputError: no such pose.
    """
    if isinstance(pose, str) and pose in POSES:
        return pose
    if isinstance(pose, int | np.integer) and 0 <= pose < len(POSE_NAMES):
        return POSE_NAMES[pose]
    valid = ", ".join(POSE_NAMES)
    raise InputError(f"pose: expected one of {valid} or 0 to {len(POSE_NAMES) - 1}, got {pose!r}")


def pose_angles(pose: str | int | Angles) -> Angles:
    """The angles of a pose given by name, by its place in `POSE_NAMES`, or as these angles.

    Raises:
        InputError: no such pose, angles that are not three finite numbers a bone.
    """
    if not isinstance(pose, Mapping):
        return POSES[pose_name(pose)]
    for bone, xyz in pose.items():
        if np.shape(xyz) != (3,) or not np.isfinite(xyz).all():
            raise InputError(f"pose: expected three angles for {bone}, got {xyz!r}")
    return pose


def between(first: float, second: float, share: float) -> Angles:
    """The angles of a pose between two of the eight, which may be one and the same.

    Args:
        first, second: in [0, 1), the places of the two among the eight.
        share: in [0, 1], of the second.
    """
    one, other = (POSES[POSE_NAMES[int(place * len(POSE_NAMES))]] for place in (first, second))
    return {
        bone: tuple((1 - share) * np.asarray(one.get(bone, (0, 0, 0))) + share * np.asarray(other.get(bone, (0, 0, 0))))
        for bone in JOINTS
        if bone in one or bone in other
    }


def bone_rotations(pose: str | int | Angles, offsets: np.ndarray | None = None) -> dict[str, np.ndarray]:
    """Rotation matrices of a pose: bone → (3, 3), first about x, then y, then z, all three axes fixed in the world.

    Args:
        pose: see `pose_angles`.
        offsets: (J, 3) degrees, added to the angles of the J `JOINTS`; a joint the pose leaves alone is at 0.

    Raises:
        InputError: see `pose_angles`.
    """
    angles = pose_angles(pose)
    if offsets is not None:
        angles = {bone: np.add(angles.get(bone, 0), offset) for bone, offset in zip(JOINTS, offsets, strict=True)}
    return {bone: Rotation.from_euler("xyz", xyz, degrees=True).as_matrix() for bone, xyz in angles.items()}
