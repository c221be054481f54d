"""Generated bodies whose upper half stands in one pose and whose lower half in another: three times as many poses.

What `bodies.py` makes stands in eight poses and no other, and a net that has seen those alone draws no new one. These
serve where halves are put together.
"""

from collections.abc import Mapping, Sequence
from functools import cached_property

import numpy as np

from lssd_learn.cache import fingerprint
from lssd_learn.collections.base import Collection
from lssd_learn.collections.generated.bodies import Bodies
from lssd_learn.collections.generated.body.parts import half_of
from lssd_learn.collections.generated.body.poses import POSES, Angles
from lssd_learn.shapes import Mesh

# Goes up whenever the same arguments give other shapes; what stands in `POSES` is part of the key anyway.
GENERATOR_VERSION = 1


def mixed_pose(lower: str, upper: str) -> Angles:
    """The angles of one of `POSES` for the bones of the lower body, those of another for the bones of the upper one."""
    return half_pose(lower, "lower_body") | half_pose(upper, "upper_body")


def named_pose(label: str) -> Angles:
    """The angles of a pose by its label in `Bodies` or `Mixed`."""
    return mixed_pose(*label.split("+")) if "+" in label else POSES[label]


def half_pose(pose: str, half: str) -> dict[str, Sequence[float]]:
    """The angles of one of `POSES` for the bones of "upper_body" or "lower_body" alone."""
    return {bone: xyz for bone, xyz in POSES[pose].items() if half_of(bone) == half}


def _distinct(half: str) -> list[str]:
    """The poses that differ on a half, by the first of each kind."""
    return [pose for pose in POSES if half_pose(pose, half) not in [half_pose(p, half) for p in _before(pose)]]


def _before(pose: str) -> list[str]:
    return list(POSES)[: list(POSES).index(pose)]


# Lower and upper poses: every combination of those that differ.
MIXED_POSES = [(lower, upper) for lower in _distinct("lower_body") for upper in _distinct("upper_body")]


class Mixed(Collection):
    """n human bodies in metres, Z up; body i stands in the mixed pose i mod 24.

    Args:
        n, seed, topology: see `Bodies`, whose parameters these have.

    Attributes:
        bodies: `Bodies` with the same parameters.
        parameters: (n, 12) float64 in [0, 1].
        groups: "pose": (n,) names, as sitting+t_pose, the lower half's first.
        parts: those of `Bodies`; loads the body model.

    Raises:
        InputError: an argument out of its range.
    """

    up = "z"
    parameters: np.ndarray

    def __init__(self, n: int = 400, seed: int = 0, topology: str = "notoes"):
        self.bodies = Bodies(n, seed, topology)
        self.names, self.parameters = self.bodies.names, self.bodies.parameters
        self.parameter_names = self.bodies.parameter_names
        self.poses = [MIXED_POSES[i % len(MIXED_POSES)] for i in range(n)]
        self.groups = {"pose": np.array(["+".join(halves) for halves in self.poses])}
        self.key = fingerprint("mixed", self.bodies.key, [self.shape_key(i) for i in range(n)])

    def __len__(self) -> int:
        return len(self.bodies)

    def __getitem__(self, i: int) -> Mesh:
        return self.bodies.make(self.parameters[i], mixed_pose(*self.poses[i]))

    @cached_property
    def parts(self) -> Mapping[str, np.ndarray]:
        return self.bodies.parts

    def shape_key(self, i: int) -> str:
        angles = {bone: list(xyz) for bone, xyz in mixed_pose(*self.poses[i]).items()}
        return fingerprint("mixed", GENERATOR_VERSION, self.bodies.shape_key(i), angles)
