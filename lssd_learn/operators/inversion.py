"""A shape of given operators by optimisation: no training set, and no net."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import torch
from jaxtyping import Float, Int
from torch import Tensor

from lssd_learn.differentiable.operators import KINDS, vertex_operators
from lssd_learn.errors import InputError, check_whole
from lssd_learn.latent.differences import Seen


@dataclass(frozen=True, eq=False)
class Found:
    """A shape that an optimisation has found.

    Attributes:
        vertices: (V, 3).
        losses: of the start, and after each round.
    """

    vertices: Float[np.ndarray, "V 3"]
    losses: list[float]


def shape_of_operators(
    operators: Float[Tensor, "channels m m"],
    start: Float[np.ndarray, "V 3"],
    faces: Int[np.ndarray, "F 3"],
    functions: Float[Tensor, "V m"],
    seen: Seen,
    kinds: Sequence[str] = KINDS,
    rounds: int = 100,
    stay: float = 0.03,
) -> Found:
    """Vertices near `start` whose operators come nearest to given ones, without any training: up to a rigid motion.

    Points are displaced by affine maps that vary over the surface as the latent functions do, so that a part can turn
    with its detail, and the sum of squared differences of operators falls by L-BFGS. Found is the shape of the nearest
    valley: a start in another pose ends in a wrong one, and area and conformal operators alone do not tell which way a
    part is bent.

    Args:
        operators: (channels, m, m) symmetric, of the kinds.
        start: (V, 3), as the vertices of a neighbour.
        faces, functions, seen, kinds: see `vertex_operators`; best are the functions of the start itself.
        rounds: at most, of twenty steps each: it ends when they no longer gain a thousandth.
        stay: what a mean square displacement by as much as the start is large adds to the loss, of each field.

    Raises:
        InputError: as `vertex_operators`; operators of another shape; a loss that is not finite.
    """
    check_whole("rounds", rounds, 1)
    m = functions.shape[1]
    if operators.shape != (len(kinds), m, m):
        raise InputError(f"operators: expected {(len(kinds), m, m)}, got {tuple(operators.shape)}")
    X, F = torch.tensor(np.asarray(start)).to(functions), torch.tensor(np.asarray(faces), device=functions.device)
    centred = X - X.mean(0)
    size = centred.square().sum(1).mean()
    fields = torch.cat([functions, *(functions * x[:, None] for x in centred.unbind(1))], dim=1)  # (V, 4m)
    fields = torch.linalg.qr(fields)[0] * (len(X) * size).sqrt()
    c = torch.zeros(fields.shape[1], 3).to(functions).requires_grad_()
    optimiser = torch.optim.LBFGS([c], max_iter=20, history_size=30, line_search_fn="strong_wolfe")

    def loss() -> Tensor:
        found = vertex_operators(X + fields @ c, F, functions, seen, kinds)
        return (found - operators).square().sum() + stay * c.square().sum()

    def step() -> Tensor:
        optimiser.zero_grad()
        value = loss()
        value.backward()
        return value

    losses = [float(loss().detach())]
    for _ in range(rounds):
        optimiser.step(step)  # pyright: ignore[reportArgumentType]  torch's own stub wants a float
        losses.append(float(loss().detach()))
        if not np.isfinite(losses[-1]):
            raise InputError("shape_of_operators: the loss is not finite; start nearer")
        if losses[-1] > 0.999 * losses[-2]:
            break
    return Found((X + fields @ c).detach().cpu().numpy(), losses)
