"""The paper's perceptron on operators: four fully connected layers on all entries at once.

The first layer is as wide as makes the network as large as the point-cloud baseline, PointNet B.
Source: paper, "Neural Network Details", MLPs.
"""

from collections.abc import Sequence

from jaxtyping import Float
from torch import Tensor, nn

from lssd_learn.nets.dense import dense

# Width of the first layer by number of latent functions, for one channel.
WIDTHS = {5: 369, 10: 185, 20: 62, 30: 29, 40: 17, 50: 11}

# Parameters of PointNet B with 12 outputs; the paper's widths come within 1 % of it.
PARAMETERS = 34_124


def first_width(channels: int, size: int, outputs: int, hidden: Sequence[int] = (50, 100)) -> int:
    """Width of the first layer: the paper's where it names one, else that which comes nearest to `PARAMETERS`."""
    if channels == 1 and size in WIDTHS:
        return WIDTHS[size]
    after = [*hidden, outputs]
    rest = after[0] + sum((a + 1) * b for a, b in zip(after[:-1], after[1:], strict=True))
    per_unit = channels * size * size + 1 + after[0]
    return max(1, round((PARAMETERS - rest) / per_unit))


class MLP(nn.Module):
    """(n, channels, size, size) operators → (n, outputs).

    Args:
        channels: operators a shape: 1 (area or conformal) or 2 (both).
        size: side of the operators, the number of latent functions.
        outputs: numbers to predict.
        first: width of the first layer; None takes `first_width`.
        hidden: widths of the layers between the first and the last.
        final_relu: end in a ReLU, as the authors do.
    """

    reads = "operators"

    def __init__(
        self,
        channels: int,
        size: int,
        outputs: int,
        first: int | None = None,
        hidden: Sequence[int] = (50, 100),
        final_relu: bool = False,
    ):
        super().__init__()
        width = first_width(channels, size, outputs, hidden) if first is None else first
        self.layers = dense((channels * size * size, width, *hidden, outputs), final_relu)

    def forward(self, operators: Float[Tensor, "n channels size size"]) -> Float[Tensor, "n outputs"]:
        return self.layers(operators.flatten(1))
