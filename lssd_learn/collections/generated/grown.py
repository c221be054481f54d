"""Generated bodies, each there twice: as it is, and with one place grown by a known part.

The truth for a statistic: half of the people with theirs grown, or all of them before and after.
"""

from functools import cached_property

import numpy as np

from lssd_learn.cache import fingerprint
from lssd_learn.collections.base import Collection
from lssd_learn.collections.generated.bodies import Bodies
from lssd_learn.collections.generated.body.growth import PLACES
from lssd_learn.collections.generated.body.poses import POSE_NAMES
from lssd_learn.errors import InputError, check_whole
from lssd_learn.shapes import Mesh

GENERATOR_VERSION = 1
OTHERS = ("weight", "random")


class Grown(Collection):
    """2n human bodies in metres, Z up: n people as they are, then the same people in the same poses with a place grown.

    Args:
        place: one of `PLACES`, a part of a body that no parameter of `Bodies` is about.
        area: by which part it grows; of person i, with `dose`, this times the person's dose.
        n: people, person i in pose i mod 8.
        others: what else they differ by: "weight", at random, all else in the middle; "random", all twelve parameters.
        dose: whether each person's growth is a random share of its own, uniform in [0, 1].
        seed: of all that is random.
        topology: of `Bodies`.

    Attributes:
        groups: "state": "plain" and "grown"; "person"; "pose".
        covariates: "dose", 0 of plain bodies, 1 of grown ones without `dose`.

    Raises:
        InputError: an argument out of its range.
    """

    up = "z"
    parameters: np.ndarray

    def __init__(
        self,
        place: str = "hand",
        area: float = 0.1,
        n: int = 60,
        others: str = "weight",
        dose: bool = False,
        seed: int = 0,
        topology: str = "notoes_collapse5pc",
    ):
        if place not in PLACES:
            raise InputError(f"collection.place={place}: expected one of {', '.join(PLACES)}")
        if isinstance(area, bool) or not isinstance(area, int | float) or not -0.5 <= area <= 1 or area == 0:
            raise InputError(f"collection.area={area}: expected a part from -.5 to 1, and not 0")
        check_whole("collection.n", n, 2)
        if others not in OTHERS:
            raise InputError(f"collection.others={others}: expected one of {', '.join(OTHERS)}")
        self._bodies = Bodies(1, seed, topology)
        self.place, self.area, self.others, self.seed = place, float(area), others, int(seed)
        self.parameter_names = self._bodies.parameter_names
        rng = np.random.default_rng([seed, 4])
        rows, doses = rng.random((n, len(self.parameter_names))), rng.random(n)
        if others == "weight":
            rows[:, [name != "weight" for name in self.parameter_names]] = 0.5
        self.parameters = np.concatenate([rows, rows])
        self.parameters.flags.writeable = False
        self.covariates = {"dose": np.concatenate([np.zeros(n), doses if dose else np.ones(n)])}
        poses = [POSE_NAMES[i % len(POSE_NAMES)] for i in range(n)]
        people = [f"person_{i:04d}" for i in range(n)]
        self.groups = {"state": np.repeat(["plain", "grown"], n), "person": np.array(people * 2),
                       "pose": np.array(poses * 2)}  # fmt: skip
        self.names = [f"{person}_{state}" for person, state in zip(self.groups["person"], self.groups["state"],
                                                                   strict=True)]  # fmt: skip
        self.key = fingerprint("grown", [self.shape_key(i) for i in range(2 * n)])

    def __len__(self) -> int:
        return len(self.names)

    def __getitem__(self, i: int) -> Mesh:
        return self._bodies.make(self.parameters[i], str(self.groups["pose"][i]), self._growth(i))

    def shape_key(self, i: int) -> str:
        """Of a plain body what it is in `Changed`: it depends on the body and its pose alone."""
        parts = "made", self._bodies.shape_key(0), self.parameters[i].tolist(), str(self.groups["pose"][i])
        grown = self._growth(i)
        return fingerprint(*parts) if grown is None else fingerprint(*parts, GENERATOR_VERSION, *grown)

    def _growth(self, i: int) -> tuple[str, float] | None:
        amount = self.area * float(self.covariates["dose"][i])
        return (self.place, amount) if amount else None

    @cached_property
    def log_area_ratio(self) -> np.ndarray:
        """(V,) the truth: logarithm of the area of each vertex grown by the whole part over that of the plain body.

        In the rest pose, all parameters in the middle.
        """
        plain, grown = self._bodies.make({}), self._bodies.make({}, "rest", (self.place, self.area))
        return np.log(grown.vertex_areas / plain.vertex_areas)
