"""A shape of given operators by optimisation: no training set, and no net."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import torch
from jaxtyping import Float, Int
from torch import Tensor

from lssd_learn.differentiable import eigenbasis, pushed_functions, vertex_operators
from lssd_learn.differentiable.forms import vertex_masses
from lssd_learn.differentiable.operators import KINDS
from lssd_learn.errors import InputError, check_whole
from lssd_learn.latent.differences import Seen
from lssd_learn.latent.extrinsic import latent_root
from lssd_learn.latent.space import LatentSpace
from lssd_learn.operators.displacements import operator_derivatives
from lssd_learn.operators.vectors import entries

Functions = Callable[[Float[np.ndarray, "V 3"]], Float[Tensor, "V m"]]

COARSEST, GROWTH = 8, 1.5  # functions that the first stage knows; as many times more, the next one
# Of a field with the frequency of the first function after the constant; constant ones weigh `CONSTANT` of it.
PRIOR, CONSTANT = 0.2, 1e-2
DAMPING, TRIES, STILL = 1e-3, 8, 1e-3  # of the first step; dampings of a round; a step of this part of a size is none


@dataclass(frozen=True, eq=False)
class Found:
    """A shape that an optimisation has found.

    Attributes:
        vertices: (V, 3).
        losses: sums of squared differences of operators, of the start and after each round of the last stage, in which
            all functions are known.
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
    rounds: int = 16,
    prior: float = PRIOR,
) -> Found:
    """Vertices near `start` whose operators come nearest to given ones, without any training: up to a rigid motion.

    Points are displaced by affine maps that vary over the surface as the latent functions do, so that a part can turn
    with its detail: 12 m numbers. From coarse to fine: first the operators of the 8 lowest functions are met by
    displacements as smooth as these, then of 12, 18 …, each stage from where the last one ended. Without, a start a
    head too tall ends in a wrong valley. The sum of squared differences falls by the method of Levenberg and Marquardt;
    a prior, that displacements be smooth, decides what the operators leave open. Found is the shape of the nearest
    valley: a start in another pose may end in a wrong one, and area and conformal operators alone do not tell which way
    a part is bent.

    Args:
        operators: (channels, m, m) symmetric, of the kinds.
        start: (V, 3), as the vertices of a neighbour. If areas are known it is first scaled to the right one.
        faces, seen, kinds: see `vertex_operators`.
        functions: those of the start itself, or what has the functions of any vertices, see `functions_of`. These are
            asked for in each round: on another shape the start's own are not quite what its operators are seen by.
        rounds: of the last stage, at most; others have as many or 8. A stage ends when points hardly move.
        prior: weighs Σ λ_j / λ_1 |c_j|² against the sum of squares, c_j the displacements along function j in sizes of
            the shape; divided by the square of how many functions a stage knows.

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

    def known(X: Tensor, count: int) -> Tensor:
        B = functions(X.numpy()) if callable(functions) else functions
        return B.to(X)[:, :count]

    wanted = operators.to(X)
    if "area" in kinds:  # the first function is the constant
        constant = known(X, 1)[:, 0]
        X = X * (wanted[list(kinds).index("area"), 0, 0] / (constant**2 @ vertex_masses(X, F))).sqrt()
    stages = [count for i in range(m) if (count := int(COARSEST * GROWTH**i)) < m] + [m]
    losses: list[float] = []
    for count in stages:
        stage = _Stage(*_lowest(wanted, seen, kinds, count), kinds, F, lambda X, count=count: known(X, count))
        X, losses = stage.run(X, rounds if count == m else min(rounds, 8), prior / count**2)
    return Found(X.numpy(), losses)


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


@dataclass(frozen=True, eq=False)
class _Stage:
    """The search for vertices whose operators of some of the functions come nearest to those that are wanted."""

    wanted: Tensor
    seen: Seen
    kinds: Sequence[str]
    faces: Tensor
    functions: Callable[[Tensor], Tensor]

    def run(self, start: Tensor, rounds: int, prior: float) -> tuple[Tensor, list[float]]:
        """The vertices of the least loss, and the loss of the start and after each round."""
        size = (start - start.mean(0)).norm()
        fields, weights = self._fields(start)
        fields, weights = fields * size, weights.repeat_interleave(3)
        c, damping, losses, every = torch.zeros(3 * fields.shape[1]).to(start), DAMPING, [], []
        for turn in range(rounds + 1):
            every.append(X := start + fields @ c.view(-1, 3))
            B = self.functions(X)
            rest = self._misfit(X, B)
            losses.append(float(rest @ rest))
            if not np.isfinite(losses[-1]):
                raise InputError("shape_of_operators: the loss is not finite; start nearer")
            if turn == rounds or (turn and (X - every[-2]).norm() <= STILL * size):
                break
            J = operator_derivatives(X, self.faces, B, self.seen, fields, self.kinds)
            normal, slope = J @ J.mT + (prior * weights).diag(), J @ rest + prior * weights * c
            now = losses[-1] + prior * float(weights @ c**2)
            for _ in range(TRIES):
                step = -torch.linalg.solve(normal + (damping * weights).diag(), slope)
                new = self._misfit(start + fields @ (c + step).view(-1, 3), B)
                if float(new @ new + prior * weights @ (c + step) ** 2) < now:
                    break
                damping *= 10
            else:
                break
            c, damping = c + step, max(damping / 4, 1e-12)
        return every[int(np.argmin(losses))], losses

    def _misfit(self, X: Tensor, B: Tensor) -> Tensor:
        return entries(vertex_operators(X, self.faces, B, self.seen, self.kinds) - self.wanted).flatten()

    def _fields(self, X: Tensor) -> tuple[Tensor, Tensor]:
        """Functions, and these times each coordinate, a column of norm one each; and how much the prior weighs them."""
        B, centred = self.functions(X), X - X.mean(0)
        fields = torch.cat([B, *(B * x[:, None] for x in centred.unbind(1))], dim=1)
        weights = self.seen.spectrum.to(X) / self.seen.spectrum[1].to(X) + CONSTANT
        return fields / fields.norm(dim=0), weights.repeat(4)


def _lowest(operators: Tensor, seen: Seen, kinds: Sequence[str], count: int) -> tuple[Tensor, Seen]:
    """The operators of the `count` lowest functions, and what these are seen from.

    Conformal ones are divided by numbers, and are a block. Extrinsic ones are divided by a matrix: that of all
    functions, which is undone, and then that of a few.
    """
    few, found = seen.with_keep(count), []
    for D, kind in zip(operators, kinds, strict=True):
        if kind == "extrinsic":
            back, root = torch.linalg.pinv(latent_root(seen).to(D)), latent_root(few).to(D)
            found.append(root @ (back @ D @ back)[:count, :count] @ root)
        else:
            found.append(D[:count, :count])
    return torch.stack(found), few
