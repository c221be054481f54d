"""Generated spheres with bumps: which is where and how high is known, so that what an analysis finds can be judged.

As they stand, the four spheres of the paper's Figure `illustration`: two pairs, told apart by a low bump on top, while
one sphere of each has a bump of twice that height on its side.
"""

from collections.abc import Mapping, Sequence
from functools import cached_property
from hashlib import blake2b

import numpy as np
import trimesh

from lssd_learn.collections.base import Collection
from lssd_learn.errors import InputError, check_positive, check_whole
from lssd_learn.shapes import Mesh

GENERATOR_VERSION = 1  # goes up whenever the same arguments give other spheres: it is part of the cache key
FINEST = 7  # 163,842 vertices


class Bumps(Collection):
    """n spheres around zero, of radius 1 but for their bumps; Z up, one connectivity.

    A bump of height h, a dent if below 0, adds h (1 − (θ/w)²)² to the radius at the angle θ < w from the direction of
    its place, and nothing beyond.

    Args:
        places: name → direction (x, y, z) of each of the p bumps, of any length but zero.
        heights: (n, p), a row a sphere, in the order of `places`.
        widths: (p,) w in degrees, up to 180.
        groups: name → n labels.
        subdivisions: of an icosahedron: 2 is 162 vertices, 3 642, 4 2,562, 5 10,242.

    Attributes:
        parameters: (n, p) float64, the heights, with the names of the bumps.
        parts: name of a bump → (V,) bool, the vertices it can move.

    Raises:
        InputError: numbers that do not fit each other or are out of range, bumps that together reach the centre.
    """

    up = "z"
    parameters: np.ndarray

    def __init__(
        self,
        places: Mapping[str, Sequence[float]] | None = None,
        heights: Sequence[Sequence[float]] = ((0, 0), (0.5, 0), (0, 0.25), (0.5, 0.25)),
        widths: Sequence[float] = (40, 40),
        groups: Mapping[str, Sequence] | None = None,
        subdivisions: int = 4,
    ):
        places = {"side": (1, 0, 0), "top": (0, 0, 1)} if places is None else places
        check_whole("subdivisions", subdivisions, 0, FINEST)
        self.parameter_names = [str(name) for name in places]
        p = len(self.parameter_names)
        directions = _numbers("places", list(places.values()), (p, 3))
        lengths = np.linalg.norm(directions, axis=1)
        if not lengths.all():
            raise InputError(f"places: expected a direction, {self.parameter_names[lengths.argmin()]} is (0, 0, 0)")
        self.parameters = _numbers("heights", heights, (None, p))
        spans = _numbers("widths", widths, (p,))
        for width in spans:
            check_positive("widths", float(width))
            if width > 180:
                raise InputError(f"widths: expected degrees up to 180, got {width:g}")
        self.groups = _groups(groups, len(self.parameters))
        self.names = [f"sphere_{i:02d}" for i in range(len(self.parameters))]
        self._directions, self._widths = directions / lengths[:, None], np.radians(spans)
        self._subdivisions = subdivisions
        reach = np.min(1 + self.parameters @ self._profiles.T, initial=1)
        if reach <= 0:
            raise InputError(f"heights: expected bumps that leave a radius above 0, together they leave {reach:g}")
        self.parameters.flags.writeable = False
        self.key = self._key(self.parameters)

    def __len__(self) -> int:
        return len(self.names)

    def __getitem__(self, i: int) -> Mesh:
        radius = 1 + self._profiles @ self.parameters[i]
        return Mesh(radius[:, None] * self._sphere.vertices, self._sphere.faces)

    @cached_property
    def parts(self) -> dict[str, np.ndarray]:
        """(V,) bool masks."""
        return dict(zip(self.parameter_names, (self._profiles > 0).T, strict=True))

    def shape_key(self, i: int) -> str:
        """Does not depend on the other spheres, nor on any group."""
        return self._key(self.parameters[i])

    @cached_property
    def _sphere(self) -> Mesh:
        ball = trimesh.creation.icosphere(self._subdivisions)
        return Mesh(ball.vertices, ball.faces)

    @cached_property
    def _profiles(self) -> np.ndarray:
        """(V, p) what each bump of height 1 adds to the radius."""
        angles = np.arccos(np.clip(self._sphere.vertices @ self._directions.T, -1, 1))
        return np.maximum(1 - (angles / self._widths) ** 2, 0) ** 2

    def _key(self, heights: np.ndarray) -> str:
        arguments = [array.tolist() for array in (heights, self._directions, self._widths)]
        content = repr(("Bumps", GENERATOR_VERSION, self._subdivisions, *arguments))
        return blake2b(content.encode(), digest_size=16).hexdigest()


def _numbers(name: str, values, shape: tuple[int | None, ...]) -> np.ndarray:
    """`values` as a float64 array of this shape, None being any length from 1."""
    try:
        array = np.array(values, dtype=float)
    except (TypeError, ValueError):
        raise InputError(f"{name}: expected rows of as many numbers, got {values!r}") from None
    fits = array.ndim == len(shape) and all(n in (m, None) for n, m in zip(shape, array.shape, strict=True))
    if not fits or not len(array) or not np.isfinite(array).all():
        expected = " × ".join("n" if n is None else str(n) for n in shape)
        raise InputError(f"{name}: expected {expected} finite numbers, got an array of {array.shape}")
    return array


def _groups(groups: Mapping[str, Sequence] | None, n: int) -> dict[str, np.ndarray]:
    found = {str(name): np.array(list(labels)) for name, labels in (groups or {}).items()}
    for name, labels in found.items():
        if labels.shape != (n,):
            raise InputError(f"groups: expected a label of {name} for each of {n} spheres, got {len(labels)}")
    return found
