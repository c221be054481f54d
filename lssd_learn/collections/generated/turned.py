"""The shapes of another collection lying anyhow, and some of them mirrored: for methods that have to find how they lie.

Landmarks go with their shapes, so that what was known of them still is.
"""

from collections.abc import Mapping, Sequence

import numpy as np
from scipy.spatial.transform import Rotation

from lssd_learn.cache import fingerprint
from lssd_learn.collections.aligned import laid
from lssd_learn.collections.base import Collection
from lssd_learn.shapes import Shape

GENERATOR_VERSION = 1  # goes up whenever the same arguments give other shapes: it is part of the cache key


class Turned(Collection):
    """Every shape of `base` turned at random about the origin; every second one is mirrored where that is asked for.

    Vertices keep their numbers. The faces of a mirrored mesh are turned over: they look outward as they did.

    Args:
        base: n shapes.
        mirrored: whether the second, the fourth and so on are mirrored.
        seed: shape i is turned by the stream (seed, i).
    """

    def __init__(self, base: Collection, mirrored: bool = False, seed: int = 0):
        self.base, self.mirrored, self.seed = base, bool(mirrored), int(seed)
        self.names, self.groups, self.truth = base.names, base.groups, base.truth
        self.parameters, self.parameter_names = base.parameters, base.parameter_names
        self.key = None if base.key is None else fingerprint("Turned", base.key, self._how)

    def __len__(self) -> int:
        return len(self.base)

    def __getitem__(self, i: int) -> Shape:
        return laid(self.base[i], self._motion(i), np.zeros(3))

    @property
    def landmarks(self) -> Sequence[Mapping[str, int]]:
        return self.base.landmarks

    @property
    def vertex_maps(self) -> Mapping[tuple[int, int], np.ndarray]:
        return self.base.vertex_maps

    def marked(self, i: int) -> Mapping[str, np.ndarray]:
        return {name: point @ self._motion(i) for name, point in self.base.marked(i).items()}

    def shape_key(self, i: int) -> str | None:
        own = self.base.shape_key(i)
        return None if own is None else fingerprint("Turned", own, self._how, i)

    @property
    def _how(self) -> list:
        return [GENERATOR_VERSION, self.mirrored, self.seed]

    def _motion(self, i: int) -> np.ndarray:
        """(3, 3) orthogonal Q: the points of shape i are those of `base` as x Q."""
        turn = Rotation.random(rng=np.random.default_rng([self.seed, i])).as_matrix()
        return turn * ([-1.0, 1.0, 1.0] if self.mirrored and i % 2 else [1.0, 1.0, 1.0])
