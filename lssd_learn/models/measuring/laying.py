"""A body laid on a scan that lies anyhow: begun as people in many poses, of which the best are followed."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float

from lssd_learn.kdtree import cKDTree
from lssd_learn.models.measuring.figure import Figure
from lssd_learn.models.measuring.fit import FIRST, LAST, SECOND, THIRD, Fit, Scan, settled, told
from lssd_learn.models.measuring.posable import Posable, Pose
from lssd_learn.models.measuring.starts import Starts
from lssd_learn.shapes import Shape
from lssd_learn.shapes.sampling import farthest_points, sample

COARSE, FEW = 1500, 200  # vertices spread over the body for the first rounds, and to choose starts by
TRIED = 12  # starts, of which so many are followed where the first does not lie well:
FOLLOWED = 4
APART = 0.02  # metres from which on two of them are not the same
WELL = 0.004  # metres, see `Fit.off`
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
        surface = sample(shape, SURFACE, np.random.default_rng(0))
        scan, body = Scan.of(shape, surface), self.figure.body
        begun = [
            settled(self.coarse, self.loose, scan, pose, FIRST) for pose in self.starts.nearest(surface[:FEW], TRIED)
        ]
        laid = [self.coarse.lying(pose).points for pose in begun]
        away = [_apart(points, surface) for points in laid]
        best, followed = None, []
        for place in np.argsort(away, kind="stable"):
            if any(np.sqrt(((laid[place] - laid[other]) ** 2).sum(1).mean()) < APART for other in followed):
                continue
            followed.append(place)
            pose = settled(self.coarse, self.loose, scan, begun[place], SECOND)
            for stage in (THIRD, LAST):
                pose = settled(body, self.loose, scan, pose, stage)
            fit = told(body, scan, pose, self.spread)
            if best is None or fit.off + fit.missing * WELL < best.off + best.missing * WELL:
                best = fit
            if best.off < WELL or len(followed) == FOLLOWED:
                break
        assert best is not None
        return best


def _apart(points: Float[np.ndarray, "n 3"], surface: Float[np.ndarray, "m 3"]) -> float:
    """How far points of a body and of a scan are from one another, both ways; more than 10 cm count as these."""
    some = surface[:500]
    ways = (cKDTree(points).query(some)[0], cKDTree(surface).query(points)[0])
    return float(sum(np.mean(np.minimum(way, 0.1) ** 2) for way in ways))


def upright(pose: Pose) -> Float[np.ndarray, "3 3"]:
    """(3, 3) what turns rows of points so that the hips stand as they do at rest."""
    return pose.turns[0]
