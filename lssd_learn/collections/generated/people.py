"""Generated bodies like people: women and men, young and old, tall and small, slim and heavy, in random poses."""

from collections.abc import Sequence
from math import isfinite
from types import SimpleNamespace

import numpy as np
from jaxtyping import Float
from scipy.stats import beta, norm

from lssd_learn.collections.generated.bodies import Bodies
from lssd_learn.collections.generated.body.further import FURTHER_CHANGES
from lssd_learn.collections.generated.body.model import LOCAL_CHANGES
from lssd_learn.errors import InputError

# Of the local changes, which are normal about the middle: what age, gender, height and weight leave open.
DEVIATION = 0.12
# Men are so near to the male end of the model, and women to the female one.
NEAR_END = 0.15
CALIBRATED = ("height", "weight", "muscle", "proportions")  # by the body model, a beta distribution an age and gender


class People(Bodies):
    """n bodies of grown-ups whose sliders vary together as the body model's own calibration has it.

    Half are women. Ages are uniform; height, weight, muscle and proportions have the beta distributions of anny's
    `shape_distribution.py` for the age and gender, which are calibrated to growth data of the WHO; the local changes
    are independent and normal. Everything else is as in `Bodies`, of which the sliders here have three more: age,
    gender and proportions.

    Args:
        n, seed, topology, jitter, poses, scans, measures: as of `Bodies`.
        ages: years, the least and the most.
        further: how much they differ in all else that a body may change in, see `FURTHER_CHANGES`: one standard
            deviation, where 1 is the most that the body model knows; sliders are as many more. 0 for not at all.

    Raises:
        InputError: an argument out of its range.
    """

    def __init__(
        self,
        n: int = 400,
        seed: int = 0,
        topology: str = "notoes",
        jitter: float = 10,
        poses: str = "random",
        scans: int = 1,
        measures: bool = True,
        ages: Sequence[float] = (18, 80),
        further: float = 0.0,
    ):
        if len(ages) != 2 or not 1 <= ages[0] < ages[1] <= 110:
            raise InputError(f"ages: expected two numbers of years from 1 to 110, the least first, got {list(ages)}")
        if not (isfinite(further) and 0 <= further <= 1):
            raise InputError(f"further: expected a number from 0 to 1, got {further!r}")
        self.ages, self.further = (float(ages[0]), float(ages[1])), float(further)
        super().__init__(n, seed, topology, jitter=jitter, poses=poses, scans=scans, measures=measures)

    def _draw(self, people: int) -> tuple[list[str], np.ndarray]:
        names = ["muscle", "weight", "height", *LOCAL_CHANGES, "age", "gender", "proportions"]
        drawn = np.random.default_rng([self.seed, 4]).random((people, len(names)))  # a row a person, as of `Bodies`
        found = dict(zip(names, drawn.T, strict=True))
        for name in LOCAL_CHANGES:
            found[name] = np.clip(0.5 + DEVIATION * norm.ppf(found[name]), 0, 1)
        woman = found["gender"] >= 0.5
        within = 2 * found["gender"] - woman  # [0, 1) within either half
        found["gender"] = np.where(woman, 1 - NEAR_END * within, NEAR_END * within)
        age, shapes = _calibration(self.ages[0] + (self.ages[1] - self.ages[0]) * found["age"], woman)
        found["age"] = age
        for name in CALIBRATED:
            found[name] = beta.ppf(found[name], *shapes[name])
        if self.further:  # from a stream of their own: the others stay what they are without
            normal = np.random.default_rng([self.seed, 5]).normal(size=(people, len(FURTHER_CHANGES)))
            found |= dict(zip(FURTHER_CHANGES, (0.5 + self.further / 2 * normal).T, strict=True))
            names += FURTHER_CHANGES
        return names, np.clip(np.stack([found[name] for name in names], axis=1), 0, 1)

    def _arguments(self) -> tuple:
        further = ("further", self.further, list(FURTHER_CHANGES)) if self.further else ()
        return (*super()._arguments(), "people", self.ages, DEVIATION, NEAR_END, *further)


def _calibration(years: Float[np.ndarray, " n"], woman: np.ndarray) -> tuple[np.ndarray, dict[str, tuple]]:
    """(n,) the slider of age, and name → (n,) α and (n,) β of the calibrated sliders."""
    import torch
    from anny.shape_distribution import SimpleShapeDistribution

    known = SimpleShapeDistribution(SimpleNamespace(dtype=torch.float64, device="cpu", phenotype_labels=[]))
    age = known.morphological_age_mapping.morphological_to_anny_age(torch.from_numpy(years))
    shapes = {}
    for name in CALIBRATED:
        men, women = (
            [
                part.numpy()
                for part in getattr(known, f"{who}_conditional_{name}_distribution").get_distribution_params(age)
            ]
            for who in ("boys", "girls")
        )
        shapes[name] = tuple(np.where(woman, w, m) for m, w in zip(men, women, strict=True))
    return age.numpy(), shapes
