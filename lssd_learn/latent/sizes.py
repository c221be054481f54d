"""How large new shapes are beside those of a latent space: a net that has learnt metres reads millimetres wrongly."""

import logging

import numpy as np
import torch
from jaxtyping import Bool, Float
from numpy.typing import ArrayLike

from lssd_learn.collections.reading.sizes import times, unit_guess
from lssd_learn.latent.space import LatentSpace

log = logging.getLogger(__name__)

# By this factor beyond the smallest and the largest of the old shapes a new one is of another size. Men and children
# are within it, inches and centimetres are not.
FAR = 1.8


def lengths(evals: ArrayLike) -> Float[np.ndarray, " n"]:
    """(n,) how large shapes are, in their units of length, from their frequencies (n, k): of one form at any size, λ
    goes as one over the square. The upper half of them, since the lowest tell poses rather than size."""
    evals = np.asarray(evals, dtype=float)
    upper = np.maximum(evals[:, evals.shape[1] // 2 :], np.finfo(float).tiny)
    return np.exp(-0.5 * np.log(upper).mean(axis=1))


def size_ratios(new: ArrayLike, old: ArrayLike) -> tuple[Float[np.ndarray, " n"], Bool[np.ndarray, " n"]]:
    """(n,) how many times larger new shapes are than the old ones in the middle, and whether that is by far too much.

    Args:
        new, old: (n,) and (m,) lengths.
    """
    new, old = np.asarray(new, dtype=float), np.asarray(old, dtype=float)
    return new / np.median(old), (new > FAR * old.max()) | (new < old.min() / FAR)


def tell_of_other_sizes(ratios: Float[np.ndarray, " n"], far: Bool[np.ndarray, " n"], names: list[str]) -> None:
    """A warning where new shapes are in another unit, as it seems, with the factor and the units it stands for."""
    if far.any():
        some = [names[i] for i in np.flatnonzero(far)]
        step = float(np.log(np.median(ratios[far])))
        log.warning(
            "%d of %d shapes (%s) are %s than those the model was trained on%s What is read of them is not to be "
            "trusted",
            len(some), len(far), some[0] + ", …" * (len(some) > 1), times(step), unit_guess(step, "those") or ".",
        )  # fmt: skip


def tell_of_sizes_in(space: LatentSpace, new: LatentSpace) -> None:
    """The same of shapes in a latent space and of new ones pushed into it."""
    ratios, far = size_ratios(lengths(_numpy(new.evals)), lengths(_numpy(space.evals)))
    tell_of_other_sizes(ratios, far, list(new.names))


def _numpy(tensor: torch.Tensor) -> np.ndarray:
    return tensor.detach().cpu().numpy()
