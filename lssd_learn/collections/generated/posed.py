"""Bodies in poses of one's choice."""

from collections.abc import Mapping, Sequence

import numpy as np

from lssd_learn.cache import fingerprint
from lssd_learn.collections.base import Collection
from lssd_learn.collections.generated.bodies import Bodies
from lssd_learn.collections.generated.body.poses import Angles, pose_angles, pose_name
from lssd_learn.shapes import Mesh


class Posed(Collection):
    """Bodies of a collection in poses they need not stand in there, without jitter; named as body_0003:sitting.

    Args:
        bodies: whose parameters and connectivity.
        pairs: of each shape the position of the body and the pose, a name or an index.

    Raises:
        InputError: no such pose.
    """

    def __init__(self, bodies: Bodies, pairs: Sequence[tuple[int, str | int]]):
        self.bodies, self.up = bodies, bodies.up
        self.pairs = [(int(body), pose_name(pose)) for body, pose in pairs]
        self.names = [f"{bodies.names[body]}:{pose}" for body, pose in self.pairs]
        self.key = fingerprint("posed", [self.shape_key(i) for i in range(len(self))])

    def __len__(self) -> int:
        return len(self.pairs)

    def __getitem__(self, i: int) -> Mesh:
        body, pose = self.pairs[i]
        return self.bodies.make(self.bodies.sliders[body], pose)

    def shape_key(self, i: int) -> str:
        body, pose = self.pairs[i]
        own = pose == self.bodies.pose(body) and not self.bodies.jitter
        return self.bodies.shape_key(body) if own else f"{self.bodies.shape_key(body)}/{pose}"


class Made(Collection):
    """One body of any parameters and pose.

    Args:
        bodies: whose connectivity.
        parameters: (p,) as its own.
        pose: a name, an index or angles, see `pose_angles`.
        name: of the body.

    Raises:
        InputError: no such pose; when it is asked for, parameters out of range.
    """

    parameters: np.ndarray

    def __init__(self, bodies: Bodies, parameters: np.ndarray, pose: str | int | Angles, name: str):
        self.bodies, self.up, self.names = bodies, bodies.up, [name]
        self.parameters = np.asarray(parameters, dtype=float)[None]
        self.pose = pose_angles(pose) if isinstance(pose, Mapping) else pose_name(pose)
        named = {bone: list(xyz) for bone, xyz in pose.items()} if isinstance(pose, Mapping) else self.pose
        self.key = fingerprint("made", bodies.shape_key(0), self.parameters[0].tolist(), named)

    def __len__(self) -> int:
        return 1

    def __getitem__(self, i: int) -> Mesh:
        return self.bodies.make(self.parameters[i], self.pose)
