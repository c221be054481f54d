"""What a guess most likely means, given the known vectors around it: the last step of `vertex_decoder.py`.

The shapes of a collection fill a small part of the space of all vectors: a few poses, and in each the bodies that
differ by a dozen parameters. Errors of a regression fill all of it. So of each guess that part is given up which its
nearest neighbours among the training shapes do not vary by.
"""

import torch
from jaxtyping import Float
from torch import Tensor

# Part of the error's covariance that is added to that of the neighbours: fewer than there are directions, they would
# otherwise rule out the others for good.
LEAST = 0.03

# Part of the known vectors' variance that is added to the error: one that is zero could not be divided by.
ROUNDING = 1e-12


def most_likely(
    guesses: Float[Tensor, "m p"], known: Float[Tensor, "n p"], error: Float[Tensor, "p p"], neighbours: int
) -> Float[Tensor, "m p"]:
    """The mean of z given guess = z + noise, with z normal as the known vectors near the guess are.

    Neighbour i at distance d_i counts 1 − d_i² / d², d being the distance of the first that does not count: a smooth
    function of the guess, as long as the known vectors lie densely.

    Args:
        guesses: (m, p).
        known: (n, p).
        error: (p, p) covariance of the noise.
        neighbours: how many of the known vectors count, at most.

    Returns:
        (m, p).
    """
    least = (ROUNDING * known.var(0, correction=0).mean()).clamp(min=torch.finfo(known.dtype).tiny)
    error = error + least * torch.eye(len(error)).to(error)
    squares = torch.cdist(guesses, known, compute_mode="donot_use_mm_for_euclid_dist") ** 2
    reach = squares.sort(dim=1).values[:, min(neighbours, len(known) - 1), None]
    # Where all are equally far, they count alike.
    numbers = torch.finfo(reach.dtype)
    weights = (1 - squares / reach.clamp(min=numbers.tiny)).clamp(min=0) + numbers.eps
    weights = weights / weights.sum(1, keepdim=True)
    mean = weights @ known
    spread = (weights[:, None, :] * known.T) @ known - mean[:, :, None] * mean[:, None, :] + LEAST * error
    return mean + (spread @ torch.linalg.solve(spread + error, (guesses - mean)[:, :, None]))[:, :, 0]
