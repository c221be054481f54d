"""Generated human bodies: twelve (or fourteen) parameters, eight poses, random or free ones, one connectivity.

The default collection: what the regression on the latent operators learns from. Parameters, names and groups are known
at once; the body model (`body/model.py`) is loaded when the first body is asked for, and each body is computed alone.
"""

from collections.abc import Mapping, Sequence
from functools import cached_property, partial
from hashlib import blake2b
from math import isfinite
from numbers import Real
from typing import Any

import numpy as np

from lssd_learn.cache import Cache, fingerprint
from lssd_learn.collections.anthropometry.measures import NAMES, VERSION
from lssd_learn.collections.base import Collection
from lssd_learn.collections.generated.body.growth import grown_vertices, share_of
from lssd_learn.collections.generated.body.limits import FREE, NUMBERS, free_pose
from lssd_learn.collections.generated.body.limits import VERSION as LIMITS_VERSION
from lssd_learn.collections.generated.body.model import LOCAL_CHANGES, TOPOLOGIES, body_model
from lssd_learn.collections.generated.body.package import body_package_version
from lssd_learn.collections.generated.body.parts import body_parts
from lssd_learn.collections.generated.body.poses import JOINTS, POSE_NAMES, Angles, between
from lssd_learn.collections.generated.measured import measured
from lssd_learn.errors import InputError
from lssd_learn.shapes import Mesh, normalised_area

# Goes up whenever the same arguments give other bodies: it is part of the cache key.
GENERATOR_VERSION = 1
POSES_OF = ("eight", "random", "free", "eight_and_free")


class Bodies(Collection):
    """n human bodies in metres, Z up; body i stands in pose i mod 8, or in one of its own.

    Args:
        n: how many.
        seed: of the parameters, which are independent and uniform in [0, 1]. Body i does not depend on n.
        topology: one of `TOPOLOGIES`. "notoes" has 12,272 vertices, the collapsed ones about 1,229, 615 and 369; all
            are closed, of one component and oriented outward. "anny" (13,348) has toes and a mouth cavity; its eyes
            and tongue, pieces of their own, are left out.
        vary_age: age and gender vary too, as the last two parameters; the first twelve keep their values.
        jitter: degrees; every angle of every joint that some pose turns is off by a random number between ± this, from
            the seed too. Parameters and labels stay what they are without.
        normalise_area: scale every body, about the origin, to unit area: what is left of it is its proportions.
        poses: "eight"; "random": each between two of the eight, see `poses.between`; "free": every joint turned at
            random within its limits, see `limits.py`; no group "pose" then. "eight_and_free": of four bodies the last
            stands in a pose of its own, which the group "pose" calls "free", the others in the eight by turns:
            data.protocol=held_out_pose data.held_out=free asks what is made of poses never trained on.
        scans: bodies of one person, one after the other: bodies 2p and 2p + 1 are person p where there are two.
        measures: the parameters are what a tape measures of each person, in millimetres, see `measures.py`, whatever
            the pose and the topology.

    Attributes:
        sliders: (n, 12) or (n, 14) float64 in [0, 1], what a body is made of, and
        slider_names: of these.
        parameters: the sliders, or the measures.
        groups: "pose": (n,) names; "person", where one is there several times.
        parts: named (V,) vertex masks; loads the body model.

    Raises:
        InputError: an argument out of its range.
    """

    up = "z"
    further = 0.0  # see `People`

    def __init__(
        self,
        n: int = 400,
        seed: int = 0,
        topology: str = "notoes",
        vary_age: bool = False,
        jitter: float = 0,
        normalise_area: bool = False,
        poses: str = "eight",
        scans: int = 1,
        measures: bool = False,
    ):
        if topology not in TOPOLOGIES:
            raise InputError(f"topology: expected one of {', '.join(TOPOLOGIES)}, got {topology!r}")
        if poses not in POSES_OF:
            raise InputError(f"poses: expected one of {', '.join(POSES_OF)}, got {poses!r}")
        for name, value, least in (("n", n, 1), ("seed", seed, 0), ("scans", scans, 1)):
            if not isinstance(value, int | np.integer) or isinstance(value, bool) or value < least:
                raise InputError(f"{name}: expected a whole number, {least} or more, got {value!r}")
        if not isinstance(jitter, Real) or isinstance(jitter, bool) or not (isfinite(jitter) and jitter >= 0):
            raise InputError(f"jitter: expected degrees, 0 or more, got {jitter!r}")
        self.n, self.seed, self.topology, self.vary_age = int(n), int(seed), topology, bool(vary_age)
        self.jitter, self.normalise_area = float(jitter), bool(normalise_area)
        self.poses, self.scans = poses, int(scans)
        self.names = [f"body_{i:04d}" for i in range(n)]
        person = np.arange(n) // scans
        self.slider_names, drawn = self._draw(int(person[-1]) + 1)
        self.sliders = drawn[person]
        self.sliders.flags.writeable = False
        if measures and normalise_area:
            raise InputError("measures: expected bodies of their own size, not normalise_area")
        self.measures = bool(measures)
        self.parameter_names = list(NAMES) if measures else self.slider_names
        named = _named_poses(n, poses)
        self.groups = (
            {} if None in named[:1] else {"pose": np.array([FREE if name is None else name for name in named])}
        )
        if scans > 1:
            self.groups["person"] = np.array([f"person_{p:04d}" for p in person])
        own: list[Any] = [None] * n
        if poses == "random":
            own = [between(*three) for three in np.random.default_rng([seed, 3]).random((n, 3)).tolist()]
        elif poses != "eight":
            own = [free_pose(shares) for shares in np.random.default_rng([seed, 4]).random((n, NUMBERS))]
        self._poses = [angles if name is None else name for name, angles in zip(named, own, strict=True)]
        self._offsets = [None] * n
        if jitter:
            self._offsets = np.random.default_rng([seed, 2]).uniform(-jitter, jitter, (n, len(JOINTS), 3))
        self.key = self._key(self.n)
        self._cache: Cache | None = None

    def _draw(self, people: int) -> tuple[list[str], np.ndarray]:
        """The names of the sliders, and (people, p) in [0, 1]."""
        names = ["muscle", "weight", "height", *LOCAL_CHANGES]
        # Rows are drawn one after the other, so that a longer collection begins with the shorter one.
        sliders = np.random.default_rng(self.seed).random((people, len(names)))
        if not self.vary_age:
            return names, sliders
        # From a stream of their own: the first twelve stay what they are without these two.
        more = np.random.default_rng([self.seed, 1]).random((people, 2))
        return [*names, "age", "gender"], np.hstack([sliders, more])

    @cached_property
    def parameters(self) -> np.ndarray:
        """(n, p) float64: the sliders, or the measures, which loads the body model if the cache does not know them."""
        if not self.measures:
            return self.sliders
        people, scans = self.sliders[:: self.scans], self.scans
        named = [dict(zip(self.slider_names, row.tolist(), strict=True)) for row in people]
        if self._cache is None:
            return measured(named)[np.arange(self.n) // scans]
        key = fingerprint("measures", VERSION, body_package_version(), people.tolist())
        stored = self._cache.get("measures", key, lambda: {"measures": measured(named)})
        return np.asarray(stored["measures"])[np.arange(self.n) // scans]

    def keep_in(self, cache: Cache | None, workers: int | None = None) -> None:
        self._cache = cache

    def __len__(self) -> int:
        return self.n

    def __getitem__(self, i: int) -> Mesh:
        return self._mesh(self.sliders[i], self.pose(i), self._offsets[i])

    def make(
        self,
        parameters: Sequence[float] | Mapping[str, float],
        pose: str | int | Angles = "rest",
        growth: tuple[str, float] | None = None,
    ) -> Mesh:
        """One body of one's choice, in the connectivity of the collection.

        Args:
            parameters: as many values as `slider_names`, in [0, 1]; or a mapping from some of the names, and the
                others are .5, the middle.
            pose: a name or an index of `POSE_NAMES`, or angles of one's own, see `body/poses.py`; taken without jitter.
            growth: one of `growth.PLACES` and by which part its area is larger than these parameters make it.

        Raises:
            InputError: an unknown pose, bone or parameter, a wrong number of them, a value outside [0, 1].
        """
        return self._mesh(parameters, pose, None, growth)

    def pose(self, i: int) -> str | Angles:
        """How body i stands, but for jitter."""
        return self._poses[i]

    @cached_property
    def parts(self) -> dict[str, np.ndarray]:
        """(V,) bool masks: head, torso, left_arm, right_arm, left_leg, right_leg, upper_body, lower_body."""
        model = body_model(self.topology)
        return body_parts(model.bones, model.bone_weights)

    def shape_key(self, i: int) -> str:
        """Does not depend on n either: a longer collection finds what a shorter one computed."""
        return f"{self._any_number}/{i}"

    @cached_property
    def _any_number(self) -> str:
        return self._key(None)

    def _key(self, n: int | None) -> str:
        arguments = self._arguments()
        return blake2b(repr((*arguments[:3], n, *arguments[3:])).encode(), digest_size=16).hexdigest()

    def _arguments(self) -> tuple:
        """What determines the bodies, but for how many they are."""
        arguments = ("Bodies", GENERATOR_VERSION, body_package_version(), self.seed, self.topology, self.vary_age)
        if self.jitter:  # without, the key is the one from before there was jitter
            arguments += ("jitter", self.jitter)
        if self.normalise_area:
            arguments += ("normalise_area",)
        if self.poses != "eight":
            arguments += ("poses", self.poses, *([] if self.poses == "random" else [LIMITS_VERSION]))
        if self.scans > 1:
            arguments += ("scans", self.scans)
        return arguments

    def _mesh(
        self,
        parameters: Sequence[float] | Mapping[str, float],
        pose: str | int | Angles,
        offsets: np.ndarray | None = None,
        growth: tuple[str, float] | None = None,
    ) -> Mesh:
        model = body_model(self.topology, self.further > 0)
        moved = None
        if growth is not None:
            moved = partial(grown_vertices, model, place=growth[0], share=share_of(self.topology, *growth))
        mesh = Mesh(model.vertices(self._named(parameters), pose, offsets, moved), model.faces)
        return normalised_area(mesh) if self.normalise_area else mesh

    def _named(self, parameters: Sequence[float] | Mapping[str, float]) -> dict[str, float]:
        if isinstance(parameters, Mapping):
            unknown = [name for name in parameters if name not in self.slider_names]
            if unknown:
                raise InputError(f"parameters: expected some of {', '.join(self.slider_names)}, got {unknown[0]!r}")
            parameters = [parameters.get(name, 0.5) for name in self.slider_names]
        try:
            values = np.asarray(parameters, dtype=float)
        except (TypeError, ValueError):
            raise InputError(f"parameters: expected numbers, got {parameters!r}") from None
        if values.shape != (len(self.slider_names),):
            raise InputError(f"parameters: expected {len(self.slider_names)} values, got an array of {values.shape}")
        for name, value in zip(self.slider_names, values, strict=True):
            if not 0 <= value <= 1:
                raise InputError(f"parameters: expected {name} in [0, 1], got {value}")
        return dict(zip(self.slider_names, values.tolist(), strict=True))


def _named_poses(n: int, poses: str) -> list[str | None]:
    """The name of each body's pose; None of one of its own."""
    if poses == "eight_and_free":
        return [None if i % 4 == 3 else POSE_NAMES[(i - i // 4) % len(POSE_NAMES)] for i in range(n)]
    return [POSE_NAMES[i % len(POSE_NAMES)] if poses == "eight" else None for i in range(n)]
