"""Partial analogies whose answer is known: a body that is B on one half and A on the other can be made.

A is body p in pose a. B has the global sliders of p and the local ones of q, and stands in b. The truth takes the bones
and local sliders of one half from B, everything else from A.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lssd_learn.collections.generated.bodies import Bodies
from lssd_learn.collections.generated.body.poses import POSES, Angles
from lssd_learn.collections.generated.mixed import half_pose, mixed_pose
from lssd_learn.collections.generated.posed import Made
from lssd_learn.errors import InputError

# The half on which each local slider acts: where most of its change of edge lengths lies.
SLIDERS = {
    "upper_body": ("waist", "upper_arm", "bust", "belly", "torso_v_shape"),
    "lower_body": ("hips", "thigh", "calf", "upper_leg_length"),
}

ROLES = ("body", "pose", "both")


@dataclass(frozen=True)
class Mixture:
    """A is body p in pose a; B is in pose b and has the local sliders of q; `role` says in what the two differ."""

    role: str
    p: int
    q: int
    a: str
    b: str

    def shapes(self, bodies: Bodies, region: str) -> tuple[Made, Made, Made]:
        """A, B and the truth.

        Args:
            bodies: whose parameters.
            region: of `SLIDERS`, where the truth is like B.
        """
        names = list(bodies.parameter_names)
        inside = [names.index(slider) for slider in SLIDERS[region]]
        local = [names.index(slider) for sliders in SLIDERS.values() for slider in sliders]
        A = bodies.sliders[self.p]
        B, truth = A.copy(), A.copy()
        B[local], truth[inside] = bodies.sliders[self.q, local], bodies.sliders[self.q, inside]
        title = f"{bodies.names[self.p]}:{self.a}+{bodies.names[self.q]}:{self.b}"
        poses = self.a, self.b, self.pose(region)
        given = zip((A, B, truth), poses, ("A", "B", "truth"), strict=True)
        a, b, c = (Made(bodies, parameters, pose, f"{title}:{letter}") for parameters, pose, letter in given)
        return a, b, c

    def pose(self, region: str) -> Angles:
        """Of the truth."""
        return mixed_pose(*((self.a, self.b) if region == "upper_body" else (self.b, self.a)))


def draw_mixtures(bodies: Sequence[int], count: int, rng: np.random.Generator) -> list[Mixture]:
    """`count` mixtures of each role, drawn without replacement.

    Where A and B differ in pose, they do so on both halves: the truth stands as neither.

    Args:
        bodies: which.
        count: how many.
        rng: draws.

    Raises:
        InputError: more than there are.
    """
    changes = [
        (a, b) for a in POSES for b in POSES if all(half_pose(a, half) != half_pose(b, half) for half in SLIDERS)
    ]
    same, others = [(p, p) for p in bodies], [(p, q) for p in bodies for q in bodies if p != q]
    choices = {"body": (others, [(a, a) for a in POSES]), "pose": (same, changes), "both": (others, changes)}
    found = []
    for role, (pairs, poses) in choices.items():
        if count > len(pairs) * len(poses):
            raise InputError(f"pairs={count}: {len(bodies)} bodies give {len(pairs) * len(poses)} at most")
        for number in rng.choice(len(pairs) * len(poses), count, replace=False):
            found.append(Mixture(role, *pairs[number // len(poses)], *poses[number % len(poses)]))
    return found
