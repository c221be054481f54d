"""The motions that generated characters go through: plain data, and the pose it stands for at any moment.

`motion.py` makes shapes of them. Angles are those of `body/poses.py`; a motion ends where it begins.
"""

from collections.abc import Mapping
from functools import cache

import numpy as np
from scipy.interpolate import PchipInterpolator

from lssd_learn.collections.generated.body.poses import Angles
from lssd_learn.errors import InputError

# Moment in [0, 1) → angles at that moment.
Keys = Mapping[float, tuple[float, float, float]]


def _both(keys: Mapping[str, Keys], later: float = 0.0) -> dict[str, Keys]:
    """Keys of the left side for both: the right one does the same in the mirror, `later` by a part of the motion."""
    mirrored = {
        bone: {(moment + later) % 1: (x, -y, -z) for moment, (x, y, z) in some.items()} for bone, some in keys.items()
    }
    return {f"{bone}.L": some for bone, some in keys.items()} | {f"{bone}.R": some for bone, some in mirrored.items()}


_WALK = _both(
    {
        # A stride from heel strike to heel strike, the left leg first in front.
        "upperleg01": {
            0.0: (-26, 0, 0), 0.12: (-20, 0, 0), 0.32: (0, 0, 0), 0.5: (16, 0, 0), 0.6: (8, 0, 0), 0.75: (-22, 0, 0),
            0.87: (-30, 0, 0),
        },
        "lowerleg01": {
            0.0: (4, 0, 0), 0.14: (16, 0, 0), 0.4: (5, 0, 0), 0.5: (12, 0, 0), 0.62: (40, 0, 0), 0.73: (60, 0, 0),
            0.88: (22, 0, 0), 0.96: (3, 0, 0),
        },
        "foot": {
            0.0: (-2, 0, 0), 0.08: (6, 0, 0), 0.3: (-5, 0, 0), 0.45: (-10, 0, 0), 0.62: (18, 0, 0), 0.8: (-2, 0, 0),
        },
        "upperarm01": {0.0: (32, 31, 0), 0.5: (-14, 31, 0)},
        "lowerarm01": {0.05: (22, 0, 20), 0.55: (6, 0, 6)},
    },
    later=0.5,
)  # fmt: skip
_WALK["spine03"] = {0.0: (3, 0, 7), 0.5: (3, 0, -7)}

_ARM_RAISE = _both(
    {
        "clavicle": {0.0: (0, 0, 0), 0.5: (0, -14, 0)},
        "upperarm01": {0.0: (0, 33, 0), 0.25: (0, -35, 0), 0.5: (0, -105, 0), 0.75: (0, -40, -58), 0.9: (0, 12, -45)},
        "lowerarm01": {0.0: (18, 0, 18), 0.5: (20, 0, 20), 0.75: (22, 0, 22)},
    }
)

_KNEE_LEAN: dict[str, Keys] = {
    "upperleg01.R": {0.0: (0, 0, 0), 0.3: (-80, 0, 0), 0.6: (-80, 0, 0), 0.85: (0, 0, 0)},
    "lowerleg01.R": {0.0: (0, 0, 0), 0.3: (85, 0, 0), 0.6: (85, 0, 0), 0.85: (0, 0, 0)},
    "foot.R": {0.0: (0, 0, 0), 0.3: (15, 0, 0), 0.6: (15, 0, 0), 0.85: (0, 0, 0)},
    "spine04": {0.2: (0, 0, 0), 0.55: (0, 10, 0)},
    "spine03": {0.2: (0, 0, 0), 0.55: (0, 12, 0)},
    "spine02": {0.2: (0, 0, 0), 0.55: (0, 10, 0)},
    "upperarm01.L": {0.0: (0, 24, 0), 0.5: (0, 8, 0)},
    "upperarm01.R": {0.0: (0, -24, 0), 0.5: (0, 8, 0)},
    "lowerarm01.L": {0.0: (12, 0, 12)},
    "lowerarm01.R": {0.0: (12, 0, -12)},
}

_SQUAT = _both(
    {
        "upperleg01": {0.0: (-4, 0, 12), 0.45: (-112, 0, 14)},
        "lowerleg01": {0.0: (4, 0, 0), 0.45: (112, 0, 0)},
        "foot": {0.0: (0, 0, 0), 0.45: (-25, 0, 0)},
        "upperarm01": {0.0: (0, 33, 0), 0.4: (0, -50, -55), 0.6: (0, -48, -55), 0.85: (0, 25, -15)},
        "lowerarm01": {0.0: (18, 0, 18), 0.5: (22, 0, 22)},
    }
)
_SQUAT |= {"root": {0.0: (0, 0, 0), 0.45: (25, 0, 0)}, "spine03": {0.0: (0, 0, 0), 0.45: (8, 0, 0)}}

MOTIONS: dict[str, dict[str, Keys]] = {
    "walk": _WALK, "arm_raise": _ARM_RAISE, "knee_lean": _KNEE_LEAN, "squat": _SQUAT,
}  # fmt: skip


def angles(motion: str, moment: float) -> Angles:
    """The pose of a motion at a moment.

    Between its keys each angle runs on a monotone cubic, so that none overshoots.

    Args:
        motion: of `MOTIONS`.
        moment: 0 at the beginning, 1 at the end, where it begins again.

    Raises:
        InputError: no such motion.
    """
    if motion not in MOTIONS:
        raise InputError(f"motion: expected some of {', '.join(MOTIONS)}, got {motion!r}")
    return {bone: tuple(path(moment % 1).tolist()) for bone, path in _paths(motion).items()}


@cache
def _paths(motion: str) -> dict[str, PchipInterpolator]:
    paths = {}
    for bone, keys in MOTIONS[motion].items():
        moments = np.array(sorted(keys))
        values = np.array([keys[moment] for moment in moments.tolist()], dtype=float)
        # One period before and one after: the slopes at the seam are those of any other key.
        paths[bone] = PchipInterpolator(np.concatenate([moments - 1, moments, moments + 1]), np.tile(values, (3, 1)))
    return paths
