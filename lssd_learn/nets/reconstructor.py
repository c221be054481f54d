"""The paper's network from an operator back to a cloud of points: two convolutions, then three fully connected layers.

What the first fully connected layer passes on is the code of a shape. Codes can be added and subtracted: the paper's
additive analogy is `decode(encode(C) + encode(B) - encode(A))`.

Source: paper, "Reconstruction Architecture". There the last layer too ends in a ReLU; coordinates have either sign, so
here it does not.
"""

from collections.abc import Sequence

from jaxtyping import Float
from torch import Tensor, nn

from lssd_learn.errors import InputError, check_whole
from lssd_learn.nets.cnn import CNN, Layer
from lssd_learn.nets.dense import dense

LAYERS = (Layer(20, 3, 2), Layer(20, 6, 2))


class Reconstructor(nn.Module):
    """(n, channels, size, size) operators → (n, points, 3) clouds.

    Args:
        channels: operators a shape: 1 (area or conformal) or 2 (both).
        size: side of the operators, the number of latent functions.
        outputs: coordinates to predict, three a point; 1,872,412 parameters for size 40, one channel and 4,096 points.
        layers: (filters, kernel, stride) of each convolution.
        code: width of the first fully connected layer.
        hidden: widths of the layers between the code and the points.

    Raises:
        InputError: `layers` of another make, numbers below 1, outputs that are not three a point.
    """

    reads = "operators"
    writes = "clouds"

    def __init__(
        self,
        channels: int,
        size: int,
        outputs: int,
        layers: Sequence[Sequence[int]] = LAYERS,
        code: int = 128,
        hidden: Sequence[int] = (128,),
    ):
        super().__init__()
        check_whole("outputs", outputs, 1)
        if outputs % 3:
            raise InputError(f"outputs={outputs}: expected three coordinates a point")
        # Up to the code it is a regression network that ends in a ReLU.
        self.encoder = CNN(channels, size, code, layers, final_relu=True)
        self.decoder = dense((code, *hidden, outputs))

    def encode(self, operators: Float[Tensor, "n channels size size"]) -> Float[Tensor, "n code"]:
        """(n, code) what the first fully connected layer passes on, none of it below zero."""
        return self.encoder(operators)

    def decode(self, code: Float[Tensor, "n code"]) -> Float[Tensor, "n points 3"]:
        """(n, points, 3) of codes (n, code); those of an analogy may be below zero."""
        return self.decoder(code).unflatten(1, (-1, 3))

    def forward(self, operators: Float[Tensor, "n channels size size"]) -> Float[Tensor, "n points 3"]:
        return self.decode(self.encode(operators))
