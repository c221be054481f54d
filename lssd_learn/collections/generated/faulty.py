"""Scans as scanners and people leave them: noise, holes, ends cut off, and bumps as clothes and hair make them.

What the person measures is known all the same, so that a reader can be judged on them.
"""

from functools import lru_cache

import numpy as np

from lssd_learn.cache import fingerprint
from lssd_learn.collections.base import Collection
from lssd_learn.collections.generated.made_of import MadeOf
from lssd_learn.errors import InputError, check_whole
from lssd_learn.shapes import Mesh
from lssd_learn.shapes.clean import cut, keep, mend
from lssd_learn.shapes.normals import normals

GENERATOR_VERSION = 1  # goes up whenever the same arguments give other shapes
FAULTS = ("noise", "holes", "cut", "bumps")
REMEMBERED = 64
# Of a shape that is as large as a person, in metres: along the normal, of a vertex, one standard deviation;
NOISE = (0.001, 0.005)
HOLES, HOLE = (2, 6), (0.03, 0.08)  # how many, and their radius;
CUT = (0.005, 0.03)  # the part of the vertices that is cut off, beyond a plane across;
BUMPS, BUMP, BROAD = (3, 8), (0.003, 0.015), (0.06, 0.2)  # how many, how high, and their radius


class Faulty(MadeOf):
    """Every mesh of `base`, in metres, with one kind of fault: shape i with that of place i mod as many as there are.

    Args:
        base: meshes.
        faults: some of `FAULTS`.
        seed: shape i has the stream (seed, i).

    Attributes:
        names, parameters, parameter_names, covariates, up: those of `base`.
        groups: those of `base`, and "fault".

    Raises:
        InputError: another fault; a shape that is no mesh.
    """

    def __init__(self, base: Collection, faults: tuple[str, ...] | list[str] = FAULTS, seed: int = 0):
        if not faults or any(fault not in FAULTS for fault in faults):
            raise InputError(f"collection.faults={list(faults)}: expected some of {', '.join(FAULTS)}")
        check_whole("collection.seed", seed, 0)
        super().__init__(base)
        self.faults, self.seed = tuple(faults), int(seed)
        self.groups = dict(base.groups) | {"fault": np.array([self.fault(i) for i in range(len(base))])}
        self.key = None if base.key is None else self._key(base.key)

    def fault(self, i: int) -> str:
        """The kind of shape i."""
        return self.faults[i % len(self.faults)]

    def __getitem__(self, i: int) -> Mesh:
        return _made(self, range(len(self))[i])

    def shape_key(self, i: int) -> str | None:
        key = self.base.shape_key(i)
        return None if key is None else self._key(key, i)

    def _key(self, of: str, *more) -> str:
        return fingerprint("Faulty", GENERATOR_VERSION, of, list(self.faults), self.seed, *more)


@lru_cache(REMEMBERED)
def _made(collection: Faulty, i: int) -> Mesh:
    mesh, fault = collection.base[i], collection.fault(i)
    if not isinstance(mesh, Mesh):
        raise InputError(f"{collection.names[i]}: expected a mesh, got a cloud")
    rng, points = np.random.default_rng([collection.seed, i]), mesh.vertices
    if fault == "noise":
        off = rng.uniform(*NOISE) * rng.normal(size=len(points))
        return Mesh(points + off[:, None] * normals(mesh), mesh.faces)
    if fault == "bumps":
        high = np.zeros(len(points))
        for centre in points[rng.integers(len(points), size=rng.integers(*BUMPS, endpoint=True))]:
            away = np.linalg.norm(points - centre, axis=1) / rng.uniform(*BROAD)
            high += rng.uniform(*BUMP) * np.maximum(1 - away**2, 0) ** 2
        return Mesh(points + high[:, None] * normals(mesh), mesh.faces)
    if fault == "cut":
        direction = rng.normal(size=3)
        along = points @ direction
        stays = along < np.quantile(along, 1 - rng.uniform(*CUT))
    else:
        stays = np.ones(len(points), dtype=bool)
        for centre in points[rng.integers(len(points), size=rng.integers(*HOLES, endpoint=True))]:
            stays &= np.linalg.norm(points - centre, axis=1) > rng.uniform(*HOLE)
    whole = mend(mesh, collection.names[i])
    left = np.asarray(stays[whole.vertex_index][whole.mesh.faces].all(axis=1))
    return keep(cut(whole, left, fault)).mesh
