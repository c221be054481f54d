"""Generated shapes as a scanner of bones gives them: with an inner wall, openings in it, and loose debris inside.

What differs between the shapes of the base is known, so that what is found on their walls can be judged.
"""

from collections.abc import Mapping, Sequence
from functools import lru_cache

import numpy as np
import trimesh
from jaxtyping import Int

from lssd_learn.cache import fingerprint
from lssd_learn.collections.base import Collection
from lssd_learn.collections.generated.made_of import MadeOf
from lssd_learn.collections.reading.mask import MASK_VERSION, outer_faces
from lssd_learn.errors import InputError, check_whole
from lssd_learn.shapes import Mesh
from lssd_learn.shapes.clean import cut, keep, mend

GENERATOR_VERSION = 1  # goes up whenever the same arguments give other shapes
REMEMBERED = 256
CRUMBS = 30  # of debris, round, at most so large a part of the extent of the shape:
CRUMB = 0.02


class Walled(MadeOf):
    """Every mesh of `base` with a second wall inside it, joined to the first around openings; cleaned as a file is.

    The inner wall is the outer one, shrunk towards the middle of the shape: where that has ears or fingers they cross,
    as the walls of scans do.

    Args:
        base: meshes, in vertex correspondence or not.
        thickness: between the walls, a part of the distance from the middle.
        openings: in the walls of a shape, a face each, others on each shape.
        mask: None, or "outer": only what is seen from outside is left, see `reading.mask`.
        seed: of openings and debris; shape i has the stream (seed, i).

    Attributes:
        names, parameters, parameter_names, groups, covariates, up, landmarks: those of `base`.

    Raises:
        InputError: an argument out of its range; a shape that is no mesh.
    """

    def __init__(
        self, base: Collection, thickness: float = 0.12, openings: int = 40, mask: str | None = None, seed: int = 0
    ):
        if isinstance(thickness, bool) or not isinstance(thickness, int | float) or not 0 < thickness < 1:
            raise InputError(f"collection.thickness={thickness}: expected a part between 0 and 1")
        check_whole("collection.openings", openings, 1)
        check_whole("collection.seed", seed, 0)
        if mask not in (None, "outer"):
            raise InputError(f"collection.mask={mask}: expected outer or null")
        super().__init__(base)
        self.thickness, self.openings = float(thickness), openings
        self.mask, self.seed = mask, int(seed)
        self.key = None if base.key is None else self._key(base.key)

    def __getitem__(self, i: int) -> Mesh:
        return _walled(self, range(len(self))[i])[0]

    def shape_key(self, i: int) -> str | None:
        key = self.base.shape_key(i)
        return None if key is None else self._key(key)

    def origins(self, i: int) -> Int[np.ndarray, " V"]:
        """(V,) for each vertex of shape i the vertex of the mesh of `base`, -1 on the inner wall."""
        return _walled(self, range(len(self))[i])[1]

    @property
    def landmarks(self) -> Sequence[Mapping[str, int]]:
        """Those of `base`, at the vertices they have here; what was cut away is at the nearest that is left."""
        return [self._marks(i, marks) for i, marks in enumerate(self.base.landmarks)]

    def _marks(self, i: int, marks: Mapping[str, int]) -> dict[str, int]:
        points, before = self[i].vertices, self.base[i].vertices
        return {name: int(np.linalg.norm(points - before[v], axis=1).argmin()) for name, v in marks.items()}

    def _key(self, of: str) -> str:
        cut_by = [] if self.mask is None else [self.mask, MASK_VERSION]
        return fingerprint("Walled", GENERATOR_VERSION, of, self.thickness, self.openings, self.seed, *cut_by)


@lru_cache(REMEMBERED)
def _walled(collection: Walled, i: int) -> tuple[Mesh, np.ndarray]:
    """Shape i and its origins."""
    outer = collection.base[i]
    if not isinstance(outer, Mesh):
        raise InputError(f"{collection.names[i]}: expected a mesh to wall, got a cloud")
    rng = np.random.default_rng([collection.seed, i])
    n, middle = len(outer.vertices), outer.vertices.mean(0)
    inner = middle + (1 - collection.thickness) * (outer.vertices - middle)
    apart = rng.permutation(len(outer.faces))[: collection.openings]
    left = np.delete(outer.faces, apart, axis=0)
    start, end = outer.faces[apart].ravel(), np.roll(outer.faces[apart], -1, axis=1).ravel()
    rims = np.concatenate([np.stack([start, end, end + n], 1), np.stack([start, end + n, start + n], 1)])
    points, faces = [outer.vertices, inner], [left, left[:, ::-1] + n, rims]
    ball, extent = trimesh.creation.icosphere(1), float(np.ptp(outer.vertices, axis=0).max())
    for count in range(CRUMBS):
        centre = middle + 0.6 * rng.random() * (outer.vertices[rng.integers(n)] - middle)
        faces.append(np.array(ball.faces) + 2 * n + count * len(ball.vertices))
        points.append(centre + CRUMB * extent * rng.random() * ball.vertices)
    whole = mend(Mesh(np.concatenate(points), np.concatenate(faces)), collection.names[i])
    if collection.mask == "outer":
        whole = cut(whole, outer_faces(whole.mesh), "outer")
    kept = keep(whole)
    return kept.mesh, np.where(kept.vertex_index < n, kept.vertex_index, -1)
