"""The paper's convolutional network on operators: two convolutions with ReLU, then one fully connected layer.

Neighbouring entries of an operator couple functions of similar frequency, and that is what the kernels look at.
Source: paper, "Neural Network Details", CNNs; the 50-function table and the padding are from the authors' scripts.
"""

import math
from collections.abc import Sequence
from typing import Any, NamedTuple, cast

import numpy as np
import torch
from jaxtyping import Float
from torch import Tensor, nn
from torch.nn import functional as F

from lssd_learn.errors import InputError, check_whole
from lssd_learn.nets.dense import dense


class Layer(NamedTuple):
    """One convolution: number of filters, side of the square kernel, stride."""

    filters: int
    kernel: int
    stride: int


# By number of latent functions; every other size, 5, 10 and 30 included, takes the layers of 40.
LAYERS = {
    20: (Layer(10, 2, 1), Layer(10, 4, 2)),
    40: (Layer(10, 3, 2), Layer(10, 4, 2)),
    50: (Layer(10, 4, 2), Layer(10, 4, 2)),
}


def same_padding(size: int, kernel: int, stride: int) -> tuple[int, int]:
    """Zeros before and after an axis, as TensorFlow pads for an output of ceil(size / stride): the odd zero is last."""
    total = max((math.ceil(size / stride) - 1) * stride + kernel - size, 0)
    return total // 2, total - total // 2


class SameConv(nn.Conv2d):
    """A convolution with TensorFlow's "same" padding; torch refuses `padding="same"` with a stride."""

    def forward(self, x: Float[Tensor, "... channels rows columns"]) -> Float[Tensor, "... filters _ _"]:
        (kernel, _), (stride, _) = self.kernel_size, self.stride
        rows, columns = (same_padding(n, kernel, stride) for n in x.shape[-2:])
        return super().forward(F.pad(x, (*columns, *rows)))


def _checked(layer: Sequence[int]) -> Layer:
    if isinstance(layer, str) or not isinstance(layer, Sequence) or len(layer) != len(Layer._fields):
        raise InputError(f"layers: expected [filters, kernel, stride] of each convolution, got {layer!r}")
    for name, value in zip(Layer._fields, layer, strict=True):
        check_whole(f"layers: {name}", value, 1)
    return Layer(*layer)


class CNN(nn.Module):
    """(n, channels, size, size) operators → (n, outputs).

    Args:
        channels: operators a shape: 1 (area or conformal) or 2 (both).
        size: side of the operators, the number of latent functions.
        outputs: numbers to predict; 13,722 parameters for size 40, one channel and 12 outputs.
        layers: (filters, kernel, stride) of each convolution; None takes the paper's for this size.
        final_relu: end in a ReLU, as the authors do.
        permute: the seed of a random order the functions are brought into first, which leaves a kernel nothing of their
            neighbourhood: what of the network's success is due to that, such a run tells. None leaves them in order.

    Raises:
        InputError: `layers` of another make, or numbers below 1.
    """

    reads = "operators"

    def __init__(
        self,
        channels: int,
        size: int,
        outputs: int,
        layers: Sequence[Sequence[int]] | None = None,
        final_relu: bool = False,
        permute: int | None = None,
    ):
        super().__init__()
        self.order: Tensor | None
        if permute is not None:
            check_whole("permute", permute, 0)
            order = torch.from_numpy(np.random.default_rng(permute).permutation(size))
        self.register_buffer("order", None if permute is None else order)
        modules: list[nn.Module] = []
        side, depth = size, channels
        for layer in LAYERS.get(size, LAYERS[40]) if layers is None else layers:
            filters, kernel, stride = _checked(layer)
            modules += [SameConv(depth, filters, kernel, stride), nn.ReLU()]
            side, depth = math.ceil(side / stride), filters
        # Same numbers, other order in memory: a training step on CPU takes a quarter less.
        self.features = nn.Sequential(*modules)
        cast(Any, self.features).to(memory_format=torch.channels_last)  # not in torch's own signatures
        self.head = dense((depth * side * side, outputs), final_relu)

    def forward(self, operators: Float[Tensor, "n channels size size"]) -> Float[Tensor, "n outputs"]:
        if self.order is not None:
            operators = operators[:, :, self.order[:, None], self.order]
        return self.head(self.features(operators).flatten(1))
