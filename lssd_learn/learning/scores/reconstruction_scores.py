"""How near a reconstructed cloud or mesh comes to the true surface. All lengths are in metres, as bodies are."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from lssd_learn.errors import InputError, check_whole
from lssd_learn.shapes import Mesh, Shape, sample
from lssd_learn.shapes.nearest import Indexed

SAMPLES = 100_000


@dataclass(frozen=True)
class CloudScores:
    """Of one reconstruction. `vars` of it is flat.

    Attributes:
        cd: Chamfer distance to the true cloud, in square metres.
        cd_over_level: the same over `sampling_level`: 1 is what a perfect surface scores, in the mean. Not a lower
            bound: well spread points, and points fitted to the very sample, go below.
        f_1cm, f_2cm: F-scores, the harmonic mean of precision (points at most so far from the true surface) and recall
            (the part of the true surface at most so far from a point).
    """

    cd: float
    cd_over_level: float
    f_1cm: float
    f_2cm: float


class TrueSurface:
    """The truth about one shape, made once and compared with many reconstructions.

    Precision and recall go by area-uniform samples of the surface. The squared distance of a point to the nearest of n
    samples exceeds that to the surface by area / (πn) in the mean; precision allows for that. For a body and 100,000
    samples it is (2.4 mm)², so that without it 1 cm would mean 9.7 mm.

    Args:
        mesh: the true shape.
        cloud: (N, 3) the points of it that Chamfer distances are taken to.
        seed: of the samples.
        samples: how many.

    Raises:
        InputError: no mesh, or one without area.
    """

    def __init__(self, mesh: Mesh, cloud: ArrayLike, seed: int = 0, samples: int = SAMPLES):
        if not isinstance(mesh, Mesh):
            raise InputError(f"mesh: expected a surface to compare with, got a {type(mesh).__name__}")
        self.cloud, self.area = Indexed(cloud), mesh.area
        self.surface = Indexed(sample(mesh, samples, np.random.default_rng(seed)))

    def score(self, shape: Shape, seed: int = 0) -> CloudScores:
        """Compare a reconstruction: a cloud as it is, a mesh by as many area-uniform points as the true cloud has.

        Args:
            shape: the reconstruction.
            seed: of the points of a mesh.
        """
        n = len(self.cloud)
        points = Indexed(sample(shape, n, np.random.default_rng(seed)) if isinstance(shape, Mesh) else shape.points)
        cd = points.chamfer(self.cloud)
        level = sampling_level(self.area, len(points), n)
        to_surface, to_points = self.surface.distances(points.points), points.distances(self.surface.points)
        excess = self.area / (np.pi * len(self.surface))
        f_scores = []
        for length in (0.01, 0.02):
            precision, recall = np.mean(to_surface**2 <= length**2 + excess), np.mean(to_points <= length)
            f_scores.append(2 * precision * recall / (precision + recall) if precision + recall > 0 else 0.0)
        return CloudScores(cd, cd / level, *map(float, f_scores))


def sampling_level(area: float, n: int, m: int | None = None) -> float:
    """The Chamfer distance to be expected between two independent area-uniform samples of one smooth surface.

    In a plane with density ρ the squared distance to the nearest point is 1 / (πρ) in the mean, so each direction
    gives area / (π × points there).

    Args:
        area: of the surface.
        n, m: points of the two samples; m is n if not given, and the level 2 area / (πn).
    """
    for name, value in (("n", n), ("m", n if m is None else m)):
        check_whole(name, value, 1)
    return area / np.pi * (1 / n + 1 / (n if m is None else m))


def vertex_error(vertices: ArrayLike, truth: ArrayLike) -> float:
    """Mean distance, in metres, of the vertices (…, V, 3) of one or many meshes to the true ones.

    Raises:
        InputError: arrays that do not fit each other.
    """
    vertices, truth = np.asarray(vertices, dtype=np.float64), np.asarray(truth, dtype=np.float64)
    if vertices.shape != truth.shape or vertices.ndim < 2 or vertices.shape[-1] != 3 or vertices.size == 0:
        raise InputError(f"vertices: expected two arrays (…, V, 3) alike, got {vertices.shape} and {truth.shape}")
    return float(np.linalg.norm(vertices - truth, axis=-1).mean())
