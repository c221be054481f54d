"""A shape of given operators by optimisation: no training set, and no net."""

import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import torch
from jaxtyping import Float, Int
from torch import Tensor

from lssd_learn.differentiable import eigenbasis, pushed_functions, vertex_operators
from lssd_learn.differentiable.operators import KINDS
from lssd_learn.errors import InputError, check_whole
from lssd_learn.latent.differences import Seen
from lssd_learn.latent.space import LatentSpace
from lssd_learn.operators.vectors import entries

Functions = Callable[[Float[np.ndarray, "V 3"]], Float[Tensor, "V m"]]

TOGETHER = 60  # directions in which operators are differentiated at once
TRIES, STILL = 8, 1e-4  # dampings of a round; a step of this part of the size of a shape is none


@dataclass(frozen=True, eq=False)
class Found:
    """A shape that an optimisation has found.

    Attributes:
        vertices: (V, 3).
        losses: sums of squared differences of operators, of the start and after each round.
    """

    vertices: Float[np.ndarray, "V 3"]
    losses: list[float]


def shape_of_operators(
    operators: Float[Tensor, "channels m m"],
    start: Float[np.ndarray, "V 3"],
    faces: Int[np.ndarray, "F 3"],
    functions: Float[Tensor, "V m"] | Functions,
    seen: Seen,
    kinds: Sequence[str] = KINDS,
    rounds: int = 8,
    damping: float = 1e-3,
) -> Found:
    """Vertices near `start` whose operators come nearest to given ones, without any training: up to a rigid motion.

    Points are displaced by affine maps that vary over the surface as the latent functions do, so that a part can turn
    with its detail: 12 m numbers. The sum of squared differences of operators falls by the method of Levenberg and
    Marquardt, whose steps cost 12 m derivatives each. Found is the shape of the nearest valley: a start in another pose
    may end in a wrong one, and area and conformal operators alone do not tell which way a part is bent.

    Args:
        operators: (channels, m, m) symmetric, of the kinds.
        start: (V, 3), as the vertices of a neighbour.
        faces, seen, kinds: see `vertex_operators`.
        functions: those of the start itself, or what has the functions of any vertices, see `functions_of`. These are
            asked for in each round: on another shape the start's own are not quite what its operators are seen by.
        rounds: at most: it ends when points hardly move.
        damping: of the first step.

    Raises:
        InputError: as `vertex_operators`; operators of another shape; a loss that is not finite.
    """
    check_whole("rounds", rounds, 1)
    X: Tensor = torch.tensor(np.asarray(start, dtype=float))
    F = torch.tensor(np.asarray(faces))
    given = None if callable(functions) else functions.to(X)
    m = operators.shape[-1]
    if operators.shape != (len(kinds), m, m) or (given is not None and given.shape[1] != m):
        expected = (len(kinds), m if given is None else given.shape[1])
        raise InputError(f"operators: expected {(*expected, expected[1])}, got {tuple(operators.shape)}")
    wanted, losses = entries(operators.to(X)).flatten(), []
    for _ in range(rounds):
        B = functions(X.numpy()).to(X) if callable(functions) else functions.to(X)
        fields: Tensor = _fields(X, B)

        def misfit(c: Tensor, X=X, B=B, fields=fields) -> Tensor:
            found = vertex_operators(X + fields @ c.view(-1, 3), F, B, seen, kinds)
            return entries(found).flatten() - wanted

        zero = torch.zeros(3 * fields.shape[1]).to(X)
        losses.append(float(misfit(zero).square().sum()))
        if not np.isfinite(losses[-1]):
            raise InputError("shape_of_operators: the loss is not finite; start nearer")
        step, now, damping = _step(misfit, zero, losses[-1], damping)
        loss: float = now
        move = fields @ step.view(-1, 3)
        X = X + move
        if move.square().sum() <= STILL**2 * (X - X.mean(0)).square().sum():
            break
    return Found(X.numpy(), [*losses, loss])


def functions_of(space: LatentSpace, faces: Int[np.ndarray, "F 3"], neighbours: Sequence[int]) -> Functions:
    """A function vertices (V, 3) → the latent functions there (V, m), pushed from shapes of the same faces.

    Args:
        space: with its eigenbases.
        faces: of its shapes.
        neighbours: positions of shapes in the space.
    """
    k = space.Y.shape[1]

    def found(vertices):
        basis = eigenbasis(torch.tensor(np.asarray(vertices, dtype=float)), torch.tensor(np.asarray(faces)), k)
        return basis.evecs @ pushed_functions(space, basis, neighbours)

    return found


def _fields(X: Tensor, B: Tensor) -> Float[Tensor, "V d"]:
    """Orthonormal but for one factor: a coefficient of one moves points by the size of the shape."""
    centred = X - X.mean(0)
    fields = torch.cat([B, *(B * x[:, None] for x in centred.unbind(1))], dim=1)
    return torch.linalg.qr(fields)[0] * centred.norm()


def _step(misfit: Callable[[Tensor], Tensor], zero: Tensor, loss: float, damping: float) -> tuple[Tensor, float, float]:
    """The step of the least damping, of some, with which the loss falls, the loss there, and the next damping."""
    derivative = torch.func.vmap(lambda way: torch.func.jvp(misfit, (zero,), (way,))[1], chunk_size=TOGETHER)
    ways = torch.eye(len(zero)).to(zero)
    with warnings.catch_warnings():  # of torch against itself, on the first call
        warnings.filterwarnings("ignore", r".*torch\.jit", DeprecationWarning)
        J = derivative(ways)  # a row a direction
    normal, slope = J @ J.mT, J @ misfit(zero)
    for _ in range(TRIES):
        step = -torch.linalg.solve(normal + damping * ways, slope)
        if (new := float(misfit(step).square().sum())) < loss:
            return step, new, max(damping / 4, 1e-12)
        damping *= 10
    return zero, loss, damping
