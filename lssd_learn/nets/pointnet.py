"""The paper's baseline on point clouds: a small network for each point, a maximum over the points, a decoder.

Source: paper, Table "Size of layers in point-based architectures"; no batch normalisation, as in the authors' scripts.
"""

from typing import NamedTuple

import torch
from jaxtyping import Float
from torch import Tensor, nn

from lssd_learn.errors import InputError
from lssd_learn.nets.dense import dense
from lssd_learn.nets.pooling import pooled_features


class Variant(NamedTuple):
    """Widths of the layers each point goes through, and of the decoder's hidden layers."""

    encoder: tuple[int, ...]
    decoder: tuple[int, ...]


VARIANTS = {
    "A": Variant((32, 64, 64), (64,)),
    "B": Variant((64, 128, 128), (64,)),
    "C": Variant((64, 128, 128), (64, 128)),
}


class PointNet(nn.Module):
    """(n, points, channels) clouds → (n, outputs). The order of the points does not matter.

    Args:
        channels: coordinates a point, 3.
        size: points a cloud; taken so that all nets are built alike, any number of points works.
        outputs: numbers to predict; variant B has 34,124 parameters with 12.
        variant: "A", "B" or "C".
        final_relu: end in a ReLU, as the authors do.
    """

    reads = "clouds"

    def __init__(self, channels: int, size: int, outputs: int, variant: str = "B", final_relu: bool = False):
        super().__init__()
        if variant not in VARIANTS:
            raise InputError(f"PointNet variant must be one of {', '.join(VARIANTS)}, got {variant!r}")
        encoder, decoder = VARIANTS[variant]
        widths = (channels, *encoder)
        self.encoder = nn.ModuleList(nn.Linear(a, b) for a, b in zip(widths[:-1], widths[1:], strict=True))
        self.decoder = dense((encoder[-1], *decoder, outputs), final_relu)

    def forward(self, clouds: Float[Tensor, "n size channels"]) -> Float[Tensor, "n outputs"]:
        return self.decoder(torch.relu(pooled_features(self.encoder, clouds)))
