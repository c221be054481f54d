"""A body laid on a scan that lies anyhow: begun as people in many poses, of which the best are followed."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float

from lssd_learn.kdtree import cKDTree
from lssd_learn.models.measuring.even import even
from lssd_learn.models.measuring.figure import Figure
from lssd_learn.models.measuring.fit import FIRST, LAST, SECOND, THIRD, Fit, Scan, settled, told
from lssd_learn.models.measuring.limbs import about_face, apart, rearranged
from lssd_learn.models.measuring.posable import Posable, Pose
from lssd_learn.models.measuring.starts import Starts
from lssd_learn.shapes import Mesh, Shape
from lssd_learn.shapes.sampling import farthest_points, sample

COARSE, FEW = 1500, 200  # vertices spread over the body for the first rounds, and to choose starts by
TRIED = 12  # starts, of which so many are followed where the first does not lie well:
FOLLOWED = 4
ARRANGED, ROUNDS = 1, 2  # of these, whose limbs are laid otherwise where they lie wrong, so many times
APART = 0.02  # metres from which on two of them are not the same
WELL, WHOLE = 0.004, 0.005  # metres, see `Fit.off`; or the parts that are missing and something else: rough, but right
NEARLY = 0.022  # metres, the root of `apart`, of bodies of which no limb lies wrong
SURFACE = 8000  # points of a scan, all over it


@dataclass(frozen=True, eq=False)
class Layer:
    """Lays a body on scans.

    Attributes:
        figure: the body.
        loose: (B,) radians that joints are taken to turn, one standard deviation.
        weights, turns: (s, q), (s, B, 3, 3) of the people it begins as, see `Starts`.
    """

    figure: Figure
    loose: Float[np.ndarray, " B"]
    weights: Float[np.ndarray, "s q"]
    turns: Float[np.ndarray, "s B 3 3"]

    @cached_property
    def spread(self) -> np.ndarray:
        """Vertices all over the body."""
        return farthest_points(self.figure.body.mean.sum(axis=1), min(COARSE, len(self.figure.rest)))

    @cached_property
    def coarse(self) -> Posable:
        return self.figure.body.some(self.spread)

    @cached_property
    def starts(self) -> Starts:
        return Starts(self.coarse.some(np.arange(min(FEW, len(self.spread)))), self.weights, self.turns)

    def lay(self, shape: Shape) -> Fit:
        """Where the body lies on a scan, in metres, that is in them too."""
        rng = np.random.default_rng(0)
        surface = sample(shape, SURFACE, rng) if isinstance(shape, Mesh) else shape.points[even(shape, SURFACE, rng)]
        scan, body = Scan.of(shape, surface), self.figure.body
        tree = cKDTree(surface)
        begun = [
            settled(self.coarse, self.loose, scan, pose, FIRST) for pose in self.starts.nearest(surface[:FEW], TRIED)
        ]
        laid = [self.coarse.lying(pose).points for pose in begun]
        away = [apart(points, surface, tree) for points in laid]
        best, followed = None, []
        for place in np.argsort(away, kind="stable"):
            if any(np.sqrt(((laid[place] - laid[other]) ** 2).sum(1).mean()) < APART for other in followed):
                continue
            followed.append(place)
            pose = self._second(scan, begun[place], tree, len(followed) <= ARRANGED)
            for stage in (THIRD, LAST):
                pose = settled(body, self.loose, scan, pose, stage)
            fit = told(body, scan, pose, self.spread)
            if best is None or fit.off + fit.missing * WELL < best.off + best.missing * WELL:
                best = fit
            if best.off < WELL or max(best.missing, best.extra) < WHOLE or len(followed) == FOLLOWED:
                break
        assert best is not None
        return best

    def _second(self, scan: Scan, pose: Pose, tree: cKDTree, arranged: bool) -> Pose:
        """After the second stage; where limbs lie wrong then, or front is back, also after these are laid otherwise."""
        best = settled(self.coarse, self.loose, scan, pose, SECOND)
        least = apart(self.coarse.lying(best).points, scan.surface, tree)
        for begun in (best, about_face(self.starts.body, best)):
            other = begun
            for _ in range(ROUNDS):
                if least < NEARLY**2 or not arranged:
                    return best
                other = rearranged(self.starts.body, other, self.turns[1::2], scan.surface, tree)  # half have to do
                for stage in (FIRST, SECOND):
                    other = settled(self.coarse, self.loose, scan, other, stage)
                away = apart(self.coarse.lying(other).points, scan.surface, tree)
                if away < least:
                    least, best = away, other
        return best


def upright(pose: Pose) -> Float[np.ndarray, "3 3"]:
    """(3, 3) what turns rows of points so that the hips stand as they do at rest."""
    return pose.turns[0]
