"""Generated bodies in two groups that differ in one parameter: where they differ is known, so that a finding can be
judged.
"""

from functools import cached_property

import numpy as np

from lssd_learn.cache import fingerprint
from lssd_learn.collections.base import Collection
from lssd_learn.collections.generated.bodies import Bodies
from lssd_learn.collections.generated.body.poses import POSE_NAMES
from lssd_learn.errors import InputError, check_whole
from lssd_learn.shapes import Mesh

OTHERS = ("middle", "matched", "random")


class Changed(Collection):
    """2n human bodies in metres, Z up: n with little and n with much of one parameter; body i stands in pose i mod 8.

    Args:
        change: the parameter, one of `Bodies.parameter_names`.
        n: bodies a group.
        low, high: its values in the two groups, in [0, 1].
        others: the other eleven parameters: "middle", .5 in all bodies; "matched", random, body i of one group as body
            i of the other; "random", each body its own.
        seed: of the random ones, uniform in [0, 1].
        topology: of `Bodies`.

    Attributes:
        groups: "size": "small" and "large"; "pose".

    Raises:
        InputError: an argument out of its range.
    """

    up = "z"
    parameters: np.ndarray

    def __init__(
        self,
        change: str = "waist",
        n: int = 8,
        low: float = 0.5,
        high: float = 1.0,
        others: str = "middle",
        seed: int = 0,
        topology: str = "notoes",
    ):
        self._bodies = Bodies(1, seed, topology)
        self.parameter_names = self._bodies.parameter_names
        if change not in self.parameter_names:
            raise InputError(f"change={change}: expected one of {', '.join(self.parameter_names)}")
        check_whole("n", n, 2)
        for name, value in (("low", low), ("high", high)):
            if isinstance(value, bool) or not isinstance(value, int | float) or not 0 <= value <= 1:
                raise InputError(f"{name}={value}: expected a number in [0, 1]")
        if low == high:
            raise InputError(f"high={high}: expected another value than low")
        if others not in OTHERS:
            raise InputError(f"others={others}: expected one of {', '.join(OTHERS)}")
        self.change, self.low, self.high, self.others = change, float(low), float(high), others
        p = len(self.parameter_names)
        rows = np.random.default_rng(seed).random((2 * n if others == "random" else n, p))
        if others == "middle":
            rows[:] = 0.5
        self.parameters = np.concatenate([rows] * (2 * n // len(rows)))
        self.parameters[:, self.parameter_names.index(change)] = np.repeat([self.low, self.high], n)
        self.parameters.flags.writeable = False
        poses = [POSE_NAMES[i % n % len(POSE_NAMES)] for i in range(2 * n)]
        self.groups = {"size": np.repeat(["small", "large"], n), "pose": np.array(poses)}
        self.names = [f"{size}_{i % n:03d}" for i, size in enumerate(self.groups["size"])]
        self.key = fingerprint("changed", [self.shape_key(i) for i in range(2 * n)])

    def __len__(self) -> int:
        return len(self.names)

    def __getitem__(self, i: int) -> Mesh:
        return self._bodies.make(self.parameters[i], str(self.groups["pose"][i]))

    def shape_key(self, i: int) -> str:
        """Depends on the body and its pose alone, whatever the group."""
        pose = str(self.groups["pose"][i])
        return fingerprint("made", self._bodies.shape_key(0), self.parameters[i].tolist(), pose)

    @cached_property
    def log_area_ratio(self) -> np.ndarray:
        """(V,) the truth: logarithm of the area of each vertex with much of the parameter over that with little.

        In the rest pose, the other parameters in the middle.
        """
        small, large = (self._bodies.make({self.change: value}).vertex_areas for value in (self.low, self.high))
        return np.log(large / small)
