"""Where the vertices of a known body lie on a scan: through the map from the one that stands most like it."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float, Int

from lssd_learn.cache import Cache, fingerprint
from lssd_learn.collections import AtHand, Collection, StoredBases, eigenbases
from lssd_learn.collections.chosen import Chosen
from lssd_learn.latent.strangers import lying_alike
from lssd_learn.maps.auto import AutoMaps
from lssd_learn.shapes import Mesh

FUNCTIONS = 100  # of each body, for maps


@dataclass(frozen=True, eq=False)
class Landed:
    """A known body on each of m scans.

    Attributes:
        bodies: (m,) which one.
        points: (m, V, 3) of its vertices there.
        quality: (m,) of the maps, 1 where nothing is known of it, and `level`, from which they can be trusted.
    """

    bodies: Int[np.ndarray, " m"]
    points: Float[np.ndarray, "m V 3"]
    quality: Float[np.ndarray, " m"]
    level: float


@dataclass(frozen=True, eq=False)
class References:
    """Known bodies that scans are mapped to.

    Attributes:
        vertices: (r, V, 3) of these, in metres; faces (F, 3).
    """

    vertices: Float[np.ndarray, "r V 3"]
    faces: Int[np.ndarray, "F 3"]

    @cached_property
    def bodies(self) -> Collection:
        return AtHand([Mesh(vertices, self.faces) for vertices in self.vertices])

    def land(self, scans: Collection, cache: Cache | None = None, workers: int | None = 1) -> Landed:
        """On each scan the one that stands most like it, however that is turned.

        Args:
            scans: meshes in metres.
            cache: where eigenbases and maps are kept.
            workers: see `in_parallel`.
        """
        near = [list(range(len(self.vertices)))] * len(scans)
        chosen = [some[0] for some in lying_alike(self.bodies, scans, near, 1, cache, workers, turned=True)]
        used = sorted(set(chosen))
        both = Chosen([(self.bodies, i) for i in used] + [(scans, j) for j in range(len(scans))])
        bases = eigenbases(both, FUNCTIONS, "auto", cache, workers)
        maps = AutoMaps(bases, both)
        if cache is not None and both.key is not None and isinstance(bases, StoredBases):
            keys = bases.keys
            maps.keep_in(cache, lambda i, j, more: fingerprint("vertex_maps", AutoMaps.version, keys[i], keys[j], more))
        pairs = [(len(used) + j, used.index(i)) for j, i in enumerate(chosen)]
        maps.prepare([(i, j) for j, i in pairs], workers)
        points = np.empty((len(scans), *self.vertices.shape[1:]))
        for j, (scan, body) in enumerate(pairs):
            corners, weights = maps.points(scan, body)
            points[j] = np.einsum("vc,vcx->vx", weights, scans[j].points[corners])
        told = [maps.quality(body, scan) for scan, body in pairs]
        quality = np.array([1.0 if known is None else known for known in told])
        return Landed(np.array(chosen), points, quality, maps.level)
