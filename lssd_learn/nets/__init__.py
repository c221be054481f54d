"""Networks as plain `nn.Module`s: what turns an operator or a cloud into numbers.

All are built alike, `Net(channels, size, outputs, **options)`, from the shape of one input: an operator is
(channels, size, size), a cloud is (size, channels). Each class says in `reads` which of the two it wants. Weights
start from torch's global generator. `learning` trains them; nothing here knows of Lightning. A net with a method
`solve` finds its weights in closed form, round after round, in place of gradient descent.
"""

from lssd_learn.nets.cnn import CNN
from lssd_learn.nets.kernel_machine import KernelMachine
from lssd_learn.nets.mlp import MLP
from lssd_learn.nets.pointnet import PointNet

__all__ = ["CNN", "MLP", "KernelMachine", "PointNet", "is_solved", "reads"]


def reads(net) -> str:
    """What a net wants to read, "operators" or "clouds"; given a class, a `functools.partial` of one or an instance."""
    return getattr(net, "func", net).reads


def is_solved(net) -> bool:
    """Whether a net solves itself and wants no gradient descent, so no learning rate; given as for `reads`."""
    return hasattr(getattr(net, "func", net), "solve")
