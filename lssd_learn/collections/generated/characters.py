"""A few people, each in the same poses: two collections in one whose shapes differ in the same way, or groups by pose.

As meshes they are in vertex correspondence, with landmarks beside it; as point clouds nothing but landmarks is known.
"""

from collections.abc import Mapping, Sequence
from functools import cached_property

import numpy as np

from lssd_learn.cache import fingerprint
from lssd_learn.collections.base import Collection
from lssd_learn.collections.generated.bodies import Bodies
from lssd_learn.collections.generated.body.poses import POSE_NAMES, pose_name
from lssd_learn.errors import InputError, check_whole
from lssd_learn.kdtree import cKDTree
from lssd_learn.shapes import Mesh, PointCloud
from lssd_learn.shapes.sampling import farthest_points, spread

GENERATOR_VERSION = 1  # goes up whenever the same arguments give other clouds: it is part of the cache key


class Characters(Collection):
    """People in metres, Z up; shape i is character i // p in pose i mod p.

    Args:
        characters: how many, with random parameters, those of `Bodies` of this seed; or their own: name → parameters of
            a body by name, in [0, 1], the others being .5.
        poses: p names of `POSE_NAMES`.
        seed: of the random ones, and of the points.
        topology: of `Bodies`.
        points: None for meshes; else each shape is a cloud of so many points spread over it, no two alike.
        landmarks: vertices spread over a body, the same on all shapes; of a cloud the points nearest to them.

    Attributes:
        groups: "character" and "pose".

    Raises:
        InputError: an argument out of its range.
    """

    up = "z"
    parameters: np.ndarray

    def __init__(
        self,
        characters: int | Mapping[str, Mapping[str, float]] = 2,
        poses: Sequence[str] = POSE_NAMES,
        seed: int = 0,
        topology: str = "notoes",
        points: int | None = None,
        landmarks: int = 10,
    ):
        if not isinstance(characters, Mapping):
            check_whole("characters", characters, 1)
        self._bodies = Bodies(1 if isinstance(characters, Mapping) else characters, seed, topology)
        self.parameter_names = self._bodies.parameter_names
        people = _people(characters, self._bodies)
        if not people:
            raise InputError("characters: expected at least one, got none")
        self.poses = [pose_name(pose) for pose in ([poses] if isinstance(poses, str) else poses)]
        if not self.poses or len(set(self.poses)) < len(self.poses):
            raise InputError(f"poses: expected one or more, each once, got {', '.join(self.poses) or 'none'}")
        if points is not None:
            check_whole("points", points, 100)
        check_whole("landmarks", landmarks, 0, 100)
        self.seed, self.points, self._count = int(seed), points, landmarks
        self._pairs = [(name, pose) for name in people for pose in self.poses]
        self.names = [f"{name}_{pose}" for name, pose in self._pairs]
        self.parameters = np.array([people[name] for name, _ in self._pairs])
        self.parameters.flags.writeable = False
        names, stances = zip(*self._pairs, strict=True)
        self.groups = {"character": np.array(names), "pose": np.array(stances)}
        self.key = fingerprint("characters", landmarks, self.names, [self.shape_key(i) for i in range(len(self))])

    def __len__(self) -> int:
        return len(self._pairs)

    def __getitem__(self, i: int) -> Mesh | PointCloud:
        mesh = self._mesh(i)
        if self.points is None:
            return mesh
        return PointCloud(spread(mesh, self.points, np.random.default_rng([self.seed, i])) @ mesh.vertices)

    def make(self, parameters: Sequence[float], pose: str) -> Mesh:
        """One body of one's choice, see `Bodies.make`."""
        return self._bodies.make(parameters, pose)

    @cached_property
    def meshes(self) -> "Characters":
        """The same shapes as meshes: what clouds are compared with."""
        people = {
            str(name): dict(zip(self.parameter_names, values.tolist(), strict=True))
            for name, values in zip(self.groups["character"], self.parameters, strict=True)
        }
        return Characters(people, self.poses, self.seed, self._bodies.topology, None, self._count)

    @property
    def parts(self) -> dict[str, np.ndarray]:
        """(V,) bool masks of meshes, see `Bodies.parts`."""
        return self._bodies.parts if self.points is None else {}

    @cached_property
    def landmarks(self) -> list[dict[str, int]]:
        """A mapping (landmark name → vertex) a shape; makes the shapes."""
        if not self._count:
            return []
        marks = farthest_points(self._bodies.make({}, "rest").vertices, self._count)
        found = []
        for i in range(len(self)):
            chosen = marks
            if self.points is not None:
                chosen = cKDTree(self[i].points).query(self._mesh(i).vertices[marks])[1]
            found.append({f"landmark_{number:02d}": int(v) for number, v in enumerate(chosen)})
        return found

    def shape_key(self, i: int) -> str:
        """Does not depend on the other shapes, but for the place of a cloud, which its points are drawn by."""
        cloud = [] if self.points is None else [GENERATOR_VERSION, self.points, i]
        return fingerprint(
            "character", self._bodies.shape_key(0), self.parameters[i].tolist(), self._pairs[i][1], cloud
        )

    def _mesh(self, i: int) -> Mesh:
        return self.make(self.parameters[i], self._pairs[i][1])


def _people(characters: int | Mapping[str, Mapping[str, float]], bodies: Bodies) -> dict[str, list[float]]:
    """Name → parameters in the order of the bodies' names."""
    if not isinstance(characters, Mapping):
        return {f"character_{i:02d}": parameters.tolist() for i, parameters in enumerate(bodies.parameters)}
    found = {}
    for name, given in characters.items():
        for key, value in given.items():
            if key not in bodies.parameter_names:
                raise InputError(
                    f"characters: {name} has {key!r}, expected some of {', '.join(bodies.parameter_names)}"
                )
            if isinstance(value, bool) or not isinstance(value, int | float) or not 0 <= value <= 1:
                raise InputError(f"characters: expected {key} of {name} in [0, 1], got {value!r}")
        found[str(name)] = [float(given.get(key, 0.5)) for key in bodies.parameter_names]
    return found
