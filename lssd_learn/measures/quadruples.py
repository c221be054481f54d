"""Analogies whose answer is known: two bodies in two poses are four shapes, of which any three ask for the fourth."""

from dataclasses import dataclass

import numpy as np

from lssd_learn.collections.generated.body.poses import POSE_NAMES
from lssd_learn.errors import InputError

ROLES = ("pose", "body")


@dataclass(frozen=True)
class Quadruple:
    """A is to B as C is to the truth; each is a place in `POSE_NAMES` × bodies, body by body.

    `role` is what changes from A to B, "pose" or "body"; from A to C it is the other.
    """

    role: str
    A: int
    B: int
    C: int
    truth: int


def draw_quadruples(bodies: range, count: int, rng: np.random.Generator) -> list[Quadruple]:
    """Twice `count` analogies: as many bodies p, q and poses a, b, drawn without replacement, in both roles.

    A is p in a and the truth q in b. B is p in b and C is q in a where the pose is what changes, and the other way
    round where it is the body.

    Args:
        bodies: which.
        count: how many.
        rng: draws.

    Raises:
        InputError: more than there are.
    """
    poses = len(POSE_NAMES)
    pairs = [(p, q) for p in bodies for q in bodies if p != q]
    changes = [(a, b) for a in range(poses) for b in range(poses) if a != b]
    if count > len(pairs) * len(changes):
        raise InputError(f"quadruples={count}: {len(bodies)} bodies give {len(pairs) * len(changes)} at most")
    found = []
    for number in rng.choice(len(pairs) * len(changes), count, replace=False):
        (p, q), (a, b) = pairs[number // len(changes)], changes[number % len(changes)]
        pa, pb, qa, qb = (body * poses + pose for body in (p, q) for pose in (a, b))
        found += [Quadruple("pose", pa, pb, qa, qb), Quadruple("body", pa, qa, pb, qb)]
    return found
