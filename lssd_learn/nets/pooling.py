"""The maximum over the points of a cloud, with gradients only where they are not zero.

A maximum passes gradient to the winning point of each feature and to no other. So the winners are found without
recording anything, and only they go through the layers again with gradient: of 1,024 points at most 128 a cloud.
On one CPU core that makes a training step about four times faster than the plain way, which the tests compare it to.
"""

from collections.abc import Sequence
from typing import TypeAlias, cast

import torch
from jaxtyping import Float, Int
from torch import Tensor, nn

Layers: TypeAlias = Sequence[nn.Linear] | nn.ModuleList  # which is no Sequence, though it is one in all that matters

# Points that go through the layers at once on CPU: their activations then stay in a core's cache.
CHUNK = 1024


def pooled_features(layers: Layers, clouds: Float[Tensor, "n points channels"]) -> Float[Tensor, "n features"]:
    """Apply `layers` with a ReLU between any two to every point, then take the maximum over the points.

    Args:
        layers: the linear layers, at least one.
        clouds: (n, points, channels).

    Returns:
        (n, features), before the last ReLU: it is monotone, so it may as well follow the maximum.
    """
    layers = cast(Sequence[nn.Linear], layers)
    winners = winning_points(layers, clouds.detach())
    points = clouds.gather(1, winners.unsqueeze(-1).expand(-1, -1, clouds.shape[-1]))
    for layer in layers[:-1]:
        points = torch.relu(layer(points))
    # Winner f is needed for feature f alone: a row-wise product in place of the last layer's matrix product.
    return (points * layers[-1].weight).sum(-1) + layers[-1].bias


@torch.no_grad()
def winning_points(layers: Layers, clouds: Float[Tensor, "n points channels"]) -> Int[Tensor, "n features"]:
    """(n, features) index of the point at which each feature is largest."""
    layers = cast(Sequence[nn.Linear], layers)
    n, points, _ = clouds.shape
    step = max(1, CHUNK // points) if clouds.device.type == "cpu" else max(1, n)
    buffers = [clouds.new_empty(step * points, layer.out_features) for layer in layers]
    winners = torch.empty(n, layers[-1].out_features, dtype=torch.long, device=clouds.device)
    for i in range(0, n, step):
        chunk = clouds[i : i + step]
        rows = chunk.shape[0] * points
        values = chunk.reshape(rows, -1)
        for layer, buffer in zip(layers[:-1], buffers[:-1], strict=True):
            values = torch.addmm(layer.bias, values, layer.weight.t(), out=buffer[:rows]).relu_()
        # The last bias shifts a feature at all points alike and moves no maximum.
        values = torch.mm(values, layers[-1].weight.t(), out=buffers[-1][:rows])
        winners[i : i + step] = values.view(-1, points, layers[-1].out_features).max(1).indices
    return winners
