"""How one shape lies on another of its kind: the turn, the shift and the side that lay it there, whatever way both lie.

For shapes that differ little but in how they lie: bones, teeth, faces. A shape that bends at joints has no such turn,
which the residual tells. What `collections/aligned.py` lays a whole collection with.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from jaxtyping import Float
from scipy.spatial.transform import Rotation

from lssd_learn.errors import InputError
from lssd_learn.shapes.closest_points import NORMALS, Poses, Sampled, Search, angles, sampled
from lssd_learn.shapes.mesh import Shape

MIRROR = ("auto", "forbid", "allow")

# Lengths are in parts of the root mean square distance of a shape's points from their mean, its size.
FEW = 200  # points that all the starts are tried with
CLEAR = 1.15  # ratio of two extents from which their axes tell which is which
KEPT = (10, 3)  # poses a side that are followed further after the first rounds, and after the rest with few points
ROUNDS = (3, 6, 10)  # of matching: with all starts, with those kept, with all points
APART = 30.0  # degrees between poses that are not the same
NEAR = 0.12  # a point whose match is farther away has none
TIE = 1.15  # ratio of two residuals below which neither is better
FLOOR = 0.005  # residual below which samples of one surface differ anyway


@dataclass(frozen=True, eq=False)
class Rigid:
    """Where a source lies on a target: as `points @ rotation + shift`.

    Attributes:
        rotation: (3, 3) orthogonal, of determinant −1 where mirrored.
        shift: (3,) in the units of the target.
        scale: of the target over the source, as matched; not applied.
        residual: root mean square distance of the points of either shape from the other's surface there, the farthest
            tenth cut, in parts of the size.
        rival: the same of the best pose of this side that is turned by more than 30°; infinite where there is none.
        missing, extra: the share of the target's points that have no counterpart, and of the source's.
    """

    rotation: Float[np.ndarray, "3 3"]
    shift: Float[np.ndarray, " 3"]
    scale: float
    residual: float
    rival: float
    missing: float
    extra: float

    @property
    def mirrored(self) -> bool:
        return bool(np.linalg.det(self.rotation) < 0)

    @property
    def angle(self) -> float:
        """See `angles`."""
        return float(angles(self.rotation))


@dataclass(frozen=True, eq=False)
class Laid:
    """The best of both sides.

    Attributes:
        best, other: poses; None where the other side was not allowed.
    """

    best: Rigid
    other: Rigid | None

    @property
    def ties(self) -> list[str]:
        """In words, what neither is better of: "side", "turn"."""
        near = TIE * max(self.best.residual, FLOOR)
        side = self.other is not None and self.other.residual < near
        return ["side"] * side + ["turn"] * (self.best.rival < near)


def rigid(source: Shape | Sampled, target: Shape | Sampled, mirror: str = "auto") -> Laid:
    """The turn and shift, never a scale, that lay `source` on `target`.

    All turns of the axes of the one onto those of the other are tried, and for shapes whose axes are not clear the 60
    of the icosahedron, on both sides. From each the points of either shape are matched with the nearest of the other,
    in position and normal, and the source laid on its matches, turn and turn about (Besl and McKay 1992; trimmed:
    Chetverikov et al. 2005). Poses that do worse are left behind, and more points join in.

    Args:
        source, target: shapes, or what `sampled` made of them.
        mirror: "auto" tries both sides and keeps to the source's own where they tie; "allow" takes the better, however
            little; "forbid" mirrors nothing.

    Raises:
        InputError: another value of `mirror`, a mesh without area.
    """
    if mirror not in MIRROR:
        raise InputError(f"mirror={mirror}: expected one of {', '.join(MIRROR)}")
    own, other = both_sides(source, target, mirror != "forbid")
    return Laid(other, own) if other is not None and is_better(other, own, mirror) else Laid(own, other)


def is_better(mirrored: Rigid, own: Rigid, mirror: str) -> bool:
    """Whether the mirrored side is: by more than chance where `mirror` is "auto"."""
    if mirror == "auto":
        return TIE * max(mirrored.residual, FLOOR) < own.residual
    return mirrored.residual < own.residual


def both_sides(source: Shape | Sampled, target: Shape | Sampled, mirrored: bool = True) -> tuple[Rigid, Rigid | None]:
    """The best pose that does not mirror, and the best that does where that is asked for; see `rigid`."""
    x, y = (shape if isinstance(shape, Sampled) else sampled(shape) for shape in (source, target))
    weight = NORMALS if x.oriented and y.oriented else 0.0
    search, few = Search(x, y, weight), Search(x, y, weight, FEW)
    poses = few.rounds(_starts(x, y, (1, -1) if mirrored else (1,)), ROUNDS[0])
    poses = few.rounds(poses.some(few.best(poses, KEPT[0], 0.0)), ROUNDS[1])
    poses = search.rounds(poses.some(few.best(poses, KEPT[1], APART)), ROUNDS[2])
    residuals = search.residuals(poses)

    def best(side: int) -> Rigid:
        own = np.flatnonzero(poses.side == side)
        own = own[np.argsort(residuals[own], kind="stable")]
        found = search.polished(poses.some(own[:1]))
        turned = angles(found.Q[0].T @ poses.Q[own])
        return _told(x, y, found, search, min(residuals[own][turned > APART], default=np.inf))

    return best(1), best(-1) if mirrored else None


def _starts(x: Sampled, y: Sampled, sides: tuple[int, ...]) -> Poses:
    (axes_x, clear_x), (axes_y, clear_y) = _axes(x.points), _axes(y.points)
    turns = Rotation.create_group("O").as_matrix()
    if not (clear_x and clear_y):
        turns = np.concatenate([turns, Rotation.create_group("I").as_matrix()])
    Q = np.concatenate([side * axes_x @ turns @ axes_y.T for side in sides])
    return Poses(Q, np.zeros((len(Q), 3)), np.ones(len(Q)), np.repeat(sides, len(turns)))


def _axes(points: np.ndarray) -> tuple[np.ndarray, bool]:
    """Principal axes as the columns of a rotation, and whether the extents tell one from another."""
    squares, axes = np.linalg.eigh(points.T @ points)
    axes[:, 0] *= np.sign(np.linalg.det(axes))
    extents = np.sqrt(np.maximum(squares, 0))
    return axes, all(b > CLEAR * a for a, b in pairwise(extents))


def _told(x: Sampled, y: Sampled, p: Poses, search: Search, rival: float) -> Rigid:
    """One pose in the units of the shapes."""
    residual, ahead, back = (values[0] for values in search.off(p))
    shift = y.centre + y.size * p.t[0] - x.centre @ p.Q[0]
    scale = float(p.s[0] * y.size / x.size)
    extra, missing = (float(np.mean(away > NEAR)) for away in (ahead, back))
    return Rigid(p.Q[0], shift, scale, float(residual), float(rival), missing, extra)
