"""What the body model makes people of: where each vertex lies with every joint that it follows, and at rest.

A reader of body measures learns from it how people vary and bend, and then needs no body model.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float

from lssd_learn.collections.anthropometry.measures import TOPOLOGY, tape_parts
from lssd_learn.collections.generated.body.limits import NUMBERS, free_pose
from lssd_learn.collections.generated.body.model import body_model
from lssd_learn.collections.generated.body.parts import body_parts
from lssd_learn.collections.generated.body.poses import JOINTS, between, bone_rotations

# What turns by itself; the other bones follow that which they hang from.
BONES = (
    "root", "spine03", "spine02", "neck01", "head",
    "clavicle.L", "upperarm01.L", "lowerarm01.L", "wrist.L", "clavicle.R", "upperarm01.R", "lowerarm01.R", "wrist.R",
    "upperleg01.L", "lowerleg01.L", "foot.L", "upperleg01.R", "lowerleg01.R", "foot.R",
)  # fmt: skip
# Radians that they turn, one standard deviation: what no pose of ours turns may turn a little.
LOOSE = np.array([0.15 if bone.split(".")[0] in ("head", "clavicle", "wrist", "foot") else 1.0 for bone in BONES])
# Joints by which people are measured, see `Anthropometer`.
MARKS = ("lowerleg01.L", "foot.L", "lowerarm01.L", "lowerarm02.L", "upperarm01.L", "wrist.L", "neck01", "head")


@dataclass(frozen=True, eq=False)
class Skinned:
    """A person, see `Posable`, from the place of the first joint.

    Attributes:
        parts: (V, f, 3) where vertices lie while no joint is turned, each time the share of that joint.
        heads: (B, 3) of `BONES`.
        rest: (V, 3) vertices as they are measured, from their mean, and marks (M, 3), joints by which.
    """

    parts: Float[np.ndarray, "V f 3"]
    heads: Float[np.ndarray, "B 3"]
    rest: Float[np.ndarray, "V 3"]
    marks: Float[np.ndarray, "M 3"]


class Skin:
    """How vertices of the topology that is measured follow joints.

    Args:
        further: whether people may differ by `FURTHER_CHANGES` too.

    Attributes:
        faces: (F, 3).
        parents: (B,) of `BONES`, −1 of the first.
        joints, shares: (V, f), see `Posable`.
    """

    def __init__(self, further: bool = False):
        model = self._model = body_model(TOPOLOGY, further)
        above = model.parents
        follows = []
        for bone in range(len(above)):
            while model.bones[bone] not in BONES:
                bone = above[bone]
            follows.append(BONES.index(model.bones[bone]))
        self._follows = np.array(follows)
        own = [model.bones.index(bone) for bone in BONES]
        self.parents = np.array([-1 if above[bone] < 0 else follows[above[bone]] for bone in own])
        shares = np.zeros((len(model.bone_weights), len(BONES)))
        np.add.at(shares.T, self._follows, model.bone_weights.T)
        self.joints = np.argsort(-shares, axis=1, kind="stable")[:, : int((shares > 0).sum(axis=1).max())]
        self.shares, self.faces = np.take_along_axis(shares, self.joints, axis=1), model.faces

    @property
    def parts(self) -> dict[str, Bool[np.ndarray, " V"]]:
        """What tapes go around, see `tape_parts`."""
        return tape_parts(body_parts(self._model.bones, self._model.bone_weights), self._model.left)

    def of(self, person: Mapping[str, float]) -> Skinned:
        """A person told by sliders in [0, 1]."""
        model = self._model
        rest, resting, turned = model.joints_of(person)
        moves = (turned @ np.linalg.inv(resting))[:, :3]
        whole = np.concatenate([rest, np.ones((len(rest), 1))], axis=1)
        parts = np.zeros((len(rest), len(BONES), 3))
        for joint in range(len(BONES)):
            bones = np.flatnonzero(self._follows == joint)
            moved = model.bone_weights[:, bones] @ moves[bones].reshape(len(bones), 12)
            parts[:, joint] = np.einsum("vxy,vy->vx", moved.reshape(-1, 3, 4), whole)
        heads = turned[[model.bones.index(bone) for bone in BONES], :3, 3]
        marks = resting[[model.bones.index(bone) for bone in MARKS], :3, 3]
        each = np.take_along_axis(parts, self.joints[:, :, None], axis=1) - self.shares[..., None] * heads[0]
        return Skinned(each, heads - heads[0], rest - rest.mean(0), marks - rest.mean(0))


def some_turns(count: int, jitter: float, seed: int) -> Float[np.ndarray, "s B 3 3"]:
    """(s, B, 3, 3) turns of `BONES`: half of them between two poses of the eight, every joint off by up to `jitter`
    degrees, and half free."""
    rng = np.random.default_rng([seed, 6])
    found = np.tile(np.eye(3), (count, len(BONES), 1, 1))
    for i in range(count):
        offsets = rng.uniform(-jitter, jitter, (len(JOINTS), 3))
        angles = free_pose(rng.random(NUMBERS)) if i % 2 else between(*rng.random(3).tolist())
        for bone, turn in bone_rotations(angles, None if i % 2 else offsets).items():
            found[i, BONES.index(bone)] = turn
    return found
