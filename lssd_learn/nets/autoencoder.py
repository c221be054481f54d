"""A point auto-encoder: what a net draws that sees the very cloud it is to draw, a reference for those that do not.

Source: Achlioptas, Diamanti, Mitliagkas & Guibas, "Learning Representations and Generative Models for 3D Point Clouds",
2018; narrower, and without batch normalisation, as the paper's other nets on points.
"""

from collections.abc import Sequence

import torch
from jaxtyping import Float
from torch import Tensor, nn

from lssd_learn.errors import InputError, check_whole
from lssd_learn.nets.dense import dense
from lssd_learn.nets.pooling import pooled_features


class Autoencoder(nn.Module):
    """(n, size, channels) clouds → (n, points, 3) clouds; the order of what comes in does not matter.

    Args:
        channels: coordinates a point, 3.
        size: points a cloud that comes in; taken so that all nets are built alike, any number works.
        outputs: coordinates to predict, three a point.
        encoder: widths of the layers each point goes through; the last is that of the code, a maximum over the points.
        decoder: hidden widths from the code to the points.

    Raises:
        InputError: no layer, a width below 1, outputs that are not three a point.
    """

    reads = "clouds"
    writes = "clouds"

    def __init__(
        self,
        channels: int,
        size: int,
        outputs: int,
        encoder: Sequence[int] = (64, 128, 128),
        decoder: Sequence[int] = (128, 128),
    ):
        super().__init__()
        check_whole("outputs", outputs, 1)
        if outputs % 3:
            raise InputError(f"outputs={outputs}: expected three coordinates a point")
        if not encoder:
            raise InputError("net.encoder: expected the width of at least one layer")
        for width in encoder:
            check_whole("net.encoder", width, 1)
        widths = (channels, *encoder)
        self.encoder = nn.ModuleList(nn.Linear(a, b) for a, b in zip(widths[:-1], widths[1:], strict=True))
        self.decoder = dense((encoder[-1], *decoder, outputs))

    def encode(self, clouds: Float[Tensor, "n size channels"]) -> Float[Tensor, "n code"]:
        """(n, code), none of it below zero."""
        return torch.relu(pooled_features(self.encoder, clouds))

    def decode(self, code: Float[Tensor, "n code"]) -> Float[Tensor, "n points 3"]:
        """(n, points, 3) of codes (n, code)."""
        return self.decoder(code).unflatten(1, (-1, 3))

    def forward(self, clouds: Float[Tensor, "n size channels"]) -> Float[Tensor, "n points 3"]:
        return self.decode(self.encode(clouds))
