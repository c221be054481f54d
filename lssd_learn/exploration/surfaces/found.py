"""The surfaces of a linear model: their mean, what each term does to it, and what goes with scores of the shapes."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float
from numpy.typing import ArrayLike

from lssd_learn.collections.groups import ChosenGroups
from lssd_learn.exploration.models.known import Asked
from lssd_learn.exploration.models.strata import Stratum
from lssd_learn.exploration.surfaces.coordinates import Coordinates, coordinates
from lssd_learn.exploration.surfaces.lent import Lender
from lssd_learn.exploration.surfaces.morphs import Morph, group_morphs, model_morphs, score_morphs
from lssd_learn.latent import LatentSpace
from lssd_learn.shapes import Shape


@dataclass(frozen=True, eq=False)
class Surfaces:
    """Surfaces of n shapes, to be drawn on the mesh of one.

    Attributes:
        coordinates: of the n shapes, as that one lies.
        lender: that one.
        mean: (m, 3) coordinates of the mean surface.
        morphs: of the terms of a model.
        components: score → what goes with it.
        kept: factor → its level on surfaces that are about something else.
    """

    coordinates: Coordinates
    lender: Lender
    mean: Float[np.ndarray, "m 3"]
    morphs: Sequence[Morph]
    components: Mapping[str, Morph]
    kept: Mapping[str, str]

    def with_model(self, asked: Asked, parts: Sequence[Stratum], shown: int) -> "Surfaces":
        """The same and the surfaces of what a formula is asked about, of the same shapes; `parts` are its `strata`."""
        like = asked.shapes.tolist().index(shown)
        kept = {name: str(asked.design.values[name][like]) for name in asked.design.factors}
        return replace(self, morphs=model_morphs(self.coordinates.x, asked.design, parts, like), kept=kept)

    def with_groups(self, groups: ChosenGroups) -> "Surfaces":
        """The same and the mean surfaces of groups of the same shapes."""
        return replace(self, morphs=group_morphs(self.coordinates.x, groups.name, groups.of))


def score_surfaces(
    latent: LatentSpace,
    positions: Sequence[int] | np.ndarray,
    scores: Mapping[str, ArrayLike],
    shown: int,
    shape: Shape,
    mirror: str = "auto",
    workers: int | None = None,
) -> Surfaces:
    """What goes with scores of some shapes.

    Args:
        latent: the space of the whole collection, with its eigenbases.
        positions: n of them, in the collection.
        scores: name → n numbers, such as principal components.
        shown: position in the collection of the shape that lends its mesh.
        shape: that shape.
        mirror, workers: of `coordinates`.

    Raises:
        InputError: as `coordinates`.
    """
    some = latent.some(positions)
    found = coordinates(some, list(positions).index(shown), mirror, workers)
    along = score_morphs(found.x, {name: np.asarray(values, dtype=float) for name, values in scores.items()})
    lender = Lender.of(some, found, shape)
    return Surfaces(found, lender, found.x.mean(0), (), {morph.title: morph for morph in along}, {})
