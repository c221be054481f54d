"""Networks as plain `nn.Module`s: what turns an operator or a cloud into numbers.

All are built alike, `Net(channels, size, outputs, **options)`, from the shape of one input: an operator is
(channels, size, size), a cloud is (size, channels). Each class says in `reads` which of the two it wants. Weights
start from torch's global generator. `learning` trains them; nothing here knows of Lightning.
"""

from lssd_learn.nets.cnn import CNN
from lssd_learn.nets.mlp import MLP
from lssd_learn.nets.pointnet import PointNet

__all__ = ["CNN", "MLP", "PointNet", "reads"]


def reads(net) -> str:
    """What a net wants to read, "operators" or "clouds"; given a class, a `functools.partial` of one or an instance."""
    return getattr(net, "func", net).reads
