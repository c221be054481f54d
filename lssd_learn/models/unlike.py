"""How unlike anything a model has seen a shape is: what is read of such a shape is a guess, however good the model."""

import logging
from collections.abc import Sequence

import numpy as np
import torch
from jaxtyping import Float
from torch import Tensor

log = logging.getLogger(__name__)

# Of more training shapes so many, drawn at random, are compared among themselves.
COMPARED = 2000
# A distance to the nearest training shape by this factor above the largest among these is farther than chance has it.
BEYOND = 1.25


def unlike(
    operators: Float[Tensor, "n channels m m"], known: Float[Tensor, "N channels m m"], seed: int = 0
) -> tuple[Float[np.ndarray, " n"], Float[np.ndarray, " n"]]:
    """How far shapes lie from the nearest training shape, measured by how far these lie from one another.

    Operators are compared entry by entry, every channel in units of its own deviation over the training shapes.

    Args:
        operators: (n, channels, m, m) of new shapes.
        known: (N, channels, m, m) of the training shapes.
        seed: of the draw where there are more than `COMPARED` of these.

    Returns:
        (n,) in [0, 1] the share of training shapes that have another one as near or nearer; (n,) the distance as a part
        of the largest such distance of a training shape: above 1 the shape lies outside.
    """
    if len(known) > COMPARED:
        known = known[np.sort(np.random.default_rng(seed).choice(len(known), COMPARED, replace=False))]
    centre = known.double().mean(0)
    x, y = ((some.double() - centre).flatten(2) for some in (operators, known))
    unit = y.square().sum(2).mean(0).sqrt().clamp(min=torch.finfo(torch.float64).tiny)
    x, y = ((some / unit[:, None]).flatten(1) for some in (x, y))
    among = torch.cdist(y, y, compute_mode="donot_use_mm_for_euclid_dist").fill_diagonal_(torch.inf).amin(1)
    nearest = torch.cdist(x, y, compute_mode="donot_use_mm_for_euclid_dist").amin(1)
    share = (among[None] <= nearest[:, None]).double().mean(1)
    return share.numpy(), (nearest / among.amax()).numpy()


def radii(clouds: Float[Tensor, "n points 3"]) -> Float[np.ndarray, " n"]:
    """(n,) root mean square distances of the points of clouds (n, points, 3) from their mean."""
    centred = clouds.double() - clouds.double().mean(1, keepdim=True)
    return centred.square().sum(2).mean(1).sqrt().numpy()


def tell_of_unlike(ratios: Float[np.ndarray, " n"], names: Sequence[str]) -> None:
    """A warning that names the shapes that lie outside."""
    far = np.flatnonzero(ratios > BEYOND)
    if len(far):
        some = ", ".join(names[int(i)] for i in far[:3]) + (", …" if len(far) > 3 else "")
        log.warning(
            "%d of %d shapes (%s) are unlike anything the model has seen, up to %.3g times as far from the nearest "
            "training shape as any of these is from another: what is read of them is not to be trusted",
            len(far), len(ratios), some, ratios.max(),
        )  # fmt: skip
