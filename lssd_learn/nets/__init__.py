"""Networks as plain `nn.Module`s: what turns an operator or a cloud into numbers.

All are built alike, `Net(channels, size, outputs, **options)`, from the shape of one input: an operator is
(channels, size, size), a cloud is (size, channels). Each class says in `reads` which of the two it wants. Weights
start from torch's global generator. `learning` trains them; nothing here knows of Lightning. A net with a method
`solve` finds its weights in closed form, round after round, in place of gradient descent. One that gives points in
place of plain numbers says so in `writes`.
"""

from collections.abc import Iterator
from typing import Protocol

from torch import Tensor

from lssd_learn.nets.autoencoder import Autoencoder
from lssd_learn.nets.chamfer import chamfer, nearest, nearest_squares
from lssd_learn.nets.cnn import CNN
from lssd_learn.nets.dgcnn import DGCNN
from lssd_learn.nets.kernel_machine import KernelMachine
from lssd_learn.nets.mlp import MLP
from lssd_learn.nets.pointnet import PointNet
from lssd_learn.nets.reconstructor import Reconstructor
from lssd_learn.nets.vertex_decoder import VertexDecoder
from lssd_learn.partials import unbound

__all__ = [
    "CNN",
    "DGCNN",
    "MLP",
    "Autoencoder",
    "KernelMachine",
    "PointNet",
    "Reconstructor",
    "Solvable",
    "VertexDecoder",
    "chamfer",
    "is_solved",
    "nearest",
    "nearest_squares",
    "reads",
    "rehearses",
    "writes",
]


class Solvable(Protocol):
    """A net that solves itself in rounds, see `KernelMachine`."""

    rounds: int

    def solve(self, train: tuple[Tensor, Tensor], validation: tuple[Tensor, Tensor]) -> Iterator[tuple[Tensor, Tensor]]:
        """Yield the predictions for train and validation after each of the rounds."""
        ...


def reads(net) -> str:
    """What a net wants to read, "operators" or "clouds"; given a class, a `functools.partial` of one or an instance."""
    return unbound(net).reads


def writes(net) -> str:
    """What a net gives: "numbers" (n, outputs), or "clouds" or "vertices" (n, outputs / 3, 3); given as for `reads`.

    Points of a cloud come in any order; vertices are those of a mesh, one by one.
    """
    return getattr(unbound(net), "writes", "numbers")


def rehearses(net) -> bool:
    """Whether `solve` takes blocks of the training shapes, to leave out each in turn; given as for `reads`."""
    return getattr(unbound(net), "rehearses", False)


def is_solved(net) -> bool:
    """Whether a net solves itself and wants no gradient descent, so no learning rate; given as for `reads`."""
    return hasattr(unbound(net), "solve")
