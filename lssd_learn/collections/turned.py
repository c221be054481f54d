"""Shapes turned at random, as scanners leave them: what a method that needs no upright pose is tested on.

Landmarks go with their shapes, so that what was known of them still is.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from jaxtyping import Float
from scipy.spatial.transform import Rotation

from lssd_learn.cache import fingerprint
from lssd_learn.collections.aligned import laid
from lssd_learn.collections.base import Collection
from lssd_learn.errors import InputError
from lssd_learn.shapes import Mesh, PointCloud, Shape

TURNED = ("none", "vertical", "any")
VERSION = 2  # goes up whenever the same arguments of `Turned` give other shapes: it is part of the cache key


def check_turned(turned: str) -> None:
    """Refuse anything but one of `TURNED`.

    Raises:
        InputError: names the choices.
    """
    if turned not in TURNED:
        raise InputError(f"collection.turned={turned}: expected one of {', '.join(TURNED)}")


def random_turn(turned: str, seed: int, i: int) -> Float[np.ndarray, "3 3"]:
    """The rotation R by which shape i is turned about the origin: its points are x R.

    Args:
        turned: "vertical", about z; "any", a rotation that is uniform among all.
        seed, i: each shape has a turn of its own.
    """
    rng = np.random.default_rng([seed, i, 1])  # a stream of its own: what is turned stays what it is
    turn = Rotation.from_euler("z", rng.uniform(0, 2 * np.pi)) if turned == "vertical" else Rotation.random(rng=rng)
    return turn.as_matrix().T


def turned_shape(shape: Shape, turned: str, seed: int, i: int) -> Shape:
    """Shape i of a collection as it lies after `random_turn`; "none" leaves it as it is."""
    if turned == "none":
        return shape
    points = shape.vertices @ random_turn(turned, seed, i)
    return replace(shape, vertices=points) if isinstance(shape, Mesh) else PointCloud(points)


class Turned(Collection):
    """Every shape of `base` turned at random about the origin; every second one is mirrored where that is asked for.

    Vertices keep their numbers. The faces of a mirrored mesh are turned over: they look outward as they did.

    Args:
        base: n shapes.
        mirrored: whether the second, the fourth and so on are mirrored.
        seed: see `random_turn`.
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
        return [VERSION, self.mirrored, self.seed]

    def _motion(self, i: int) -> np.ndarray:
        """(3, 3) orthogonal Q: the points of shape i are those of `base` as x Q."""
        return random_turn("any", self.seed, i) * ([-1.0, 1.0, 1.0] if self.mirrored and i % 2 else [1.0, 1.0, 1.0])
