"""A body that varies as people do and bends at joints: a mean and modes, carried along by the joints.

Skinning is linear: a vertex is a mean of points that each follow one joint. Where these lie while no joint is turned,
where the joints are, and where the vertices lie at rest, as they are measured, all vary together with a few weights.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from jaxtyping import Float, Int
from scipy.spatial.transform import Rotation


@dataclass(frozen=True, eq=False)
class Pose:
    """How a person is made and stands.

    Attributes:
        weights: (r,) of the modes, in standard deviations.
        turns: (B, 3, 3) of each joint against the one it hangs from, as they act on columns; the first turns the body.
        place: (3,) of the first joint.
    """

    weights: Float[np.ndarray, " r"]
    turns: Float[np.ndarray, "B 3 3"]
    place: Float[np.ndarray, " 3"]


@dataclass(frozen=True, eq=False)
class Lying:
    """Where a body lies.

    Attributes:
        points: (V, 3) of its vertices, and each (V, f, 3) of their parts, times the shares of these.
        at: (B, 3) its joints, and heads (B, 3) the same while none is turned.
        world: (B, 3, 3) how joints are turned, as they act on columns.
    """

    points: Float[np.ndarray, "V 3"]
    each: Float[np.ndarray, "V f 3"]
    at: Float[np.ndarray, "B 3"]
    heads: Float[np.ndarray, "B 3"]
    world: Float[np.ndarray, "B 3 3"]


@dataclass(frozen=True, eq=False)
class Posable:
    """Bodies of V vertices, r modes and B joints, in metres; modes are for a standard deviation each.

    Attributes:
        faces: (F, 3), or (0, 3) of vertices alone.
        parents: (B,) the joint that each hangs from, before it in this order; −1 of the first.
        joints, shares: (V, f) which joints a vertex follows, and how much each; rows of the shares sum to 1.
        mean, modes: (V, f, 3), (V, f, 3, r) where what follows each joint lies, times the share.
        heads, head_modes: (B, 3), (r, B, 3) the joints.
        facing: (V, 3) normals of the mean.
    """

    faces: Int[np.ndarray, "F 3"]
    parents: Int[np.ndarray, " B"]
    joints: Int[np.ndarray, "V f"]
    shares: Float[np.ndarray, "V f"]
    mean: Float[np.ndarray, "V f 3"]
    modes: Float[np.ndarray, "V f 3 r"]
    heads: Float[np.ndarray, "B 3"]
    head_modes: Float[np.ndarray, "r B 3"]
    facing: Float[np.ndarray, "V 3"]

    def some(self, vertices: Int[np.ndarray, " v"]) -> "Posable":
        """Some vertices of it, without faces."""
        return replace(
            self,
            faces=np.empty((0, 3), dtype=int),
            joints=self.joints[vertices],
            shares=self.shares[vertices],
            mean=self.mean[vertices],
            modes=self.modes[vertices],
            facing=self.facing[vertices],
        )

    @cached_property
    def _used(self) -> tuple[np.ndarray, np.ndarray]:
        """(u,) the places of (V, f) that have a share, a quarter of them, and (u, 3, r) their modes."""
        used = np.flatnonzero(self.shares.ravel() > 0)
        return used, self.modes.reshape(self.shares.size, 3, -1)[used]

    @cached_property
    def below(self) -> Float[np.ndarray, "B B"]:
        """(B, B) row j is 1 at the joints that hang from joint j, itself among them."""
        found = np.eye(len(self.parents))
        for joint in range(len(self.parents) - 1, 0, -1):
            found[self.parents[joint]] += found[joint]
        return found

    def begun(self, weights: Float[np.ndarray, " r"], turns: Float[np.ndarray, "B 3 3"]) -> Pose:
        """So turned at the joints, where it was made."""
        return Pose(weights, turns, self._joints(weights)[0])

    def _joints(self, weights: np.ndarray) -> np.ndarray:
        return self.heads + np.tensordot(weights, self.head_modes[: len(weights)], 1)

    def world(self, turns: Float[np.ndarray, "B 3 3"]) -> Float[np.ndarray, "B 3 3"]:
        """(B, 3, 3) how each joint is turned, as it acts on columns."""
        found = np.empty_like(turns)
        for joint, parent in enumerate(self.parents):
            found[joint] = turns[joint] if parent < 0 else found[parent] @ turns[joint]
        return found

    def lying(self, pose: Pose) -> Lying:
        """Where everything lies; modes that there are no weights of are left out."""
        heads, world = self._joints(pose.weights), self.world(pose.turns)
        at = np.empty_like(heads)
        for joint, parent in enumerate(self.parents):
            at[joint] = pose.place if parent < 0 else at[parent] + world[parent] @ (heads[joint] - heads[parent])
        shift = at - np.einsum("bxy,by->bx", world, heads)
        (used, modes), parts = self._used, self.mean.copy()
        parts.reshape(-1, 3)[used] += modes[..., : len(pose.weights)] @ pose.weights
        each = np.einsum("vfxy,vfy->vfx", world[self.joints], parts) + self.shares[..., None] * shift[self.joints]
        return Lying(each.sum(axis=1), each, at, heads, world)

    def turned(self, lying: Lying) -> Float[np.ndarray, "V 3"]:
        """(V, 3) unit normals, nearly: those of the mean, turned along."""
        blend = np.einsum("vf,vfxy->vxy", self.shares, lying.world[self.joints])
        found = np.einsum("vxy,vy->vx", blend, self.facing)
        return found / np.maximum(np.linalg.norm(found, axis=1, keepdims=True), 1e-9)

    def moved(self, pose: Pose, step: Float[np.ndarray, " k"]) -> Pose:
        """After a step: of the place (3), of each joint's turn against the one it hangs from (3B), of the weights."""
        b = len(self.parents)
        more = Rotation.from_rotvec(step[3 : 3 + 3 * b].reshape(b, 3)).as_matrix()
        return Pose(pose.weights + step[3 + 3 * b :], more @ pose.turns, pose.place + step[:3])

    def rows(
        self,
        lying: Lying,
        at: Int[np.ndarray, "m c"],
        portions: Float[np.ndarray, "m c"],
        planes: Float[np.ndarray, "m 3"],
        count: int,
    ) -> Float[np.ndarray, "m k"]:
        """(m, k) how far points move along vectors for a step of `moved`, of `count` modes.

        Args:
            at: vertices that each point is a mean of, and portions of these, of sum 1.
            planes: the vectors.
        """
        m, (b, world) = len(at), (len(lying.world), lying.world)
        modes = self.head_modes[:count]
        moves = np.zeros((count, b, 3))  # of joints, which move along with those they hang from
        for joint in range(1, b):
            parent = self.parents[joint]
            moves[:, joint] = moves[:, parent] + (modes[:, joint] - modes[:, parent]) @ world[parent].T
        carried = moves - np.einsum("bxy,kby->kbx", world, modes)
        back = np.tensordot(planes, world, (1, 1))  # (m, b, 3), planes as each joint's part sees them
        line = np.arange(m)[:, None]
        along, share, each = np.zeros((m, count)), np.zeros((m, b)), np.zeros((m, b, 3))
        for corner, portion in zip(at.T, portions.T, strict=True):
            joints, weights = self.joints[corner], portion[:, None]
            for place in range(joints.shape[1]):
                some = np.flatnonzero(self.shares[corner, place] > 0)
                seen = weights[some] * back[some, joints[some, place]]
                along[some] += (seen[:, None] @ self.modes[corner[some], place][..., :count])[:, 0]
            share[line, joints] += weights * self.shares[corner]  # a vertex follows no joint twice
            each[line, joints] += weights[..., None] * lying.each[corner]
        shift = np.tensordot(planes, carried, (1, 2))  # (m, count, b)
        along += (shift @ share[..., None])[..., 0]
        arms = self.below @ each - (share @ self.below.T)[..., None] * lying.at
        above = np.concatenate([np.eye(3)[None], world[self.parents[1:]]])
        turning = np.cross(arms, planes[:, None]).transpose(1, 0, 2) @ above
        return np.hstack([planes, turning.transpose(1, 0, 2).reshape(m, -1), along])
