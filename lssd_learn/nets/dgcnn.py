"""A stronger network on point clouds than the paper's PointNet: every point looks at its neighbours.

An edge convolution gives point i, for each feature, the maximum over its neighbours j of h(x_i, x_j − x_i), where h
is a linear layer and a leaky ReLU. The neighbours are the nearest points in space at first, and the nearest in the
features of the layer before from then on: parts of a shape that are far apart see each other where they are alike.

As the linear layer comes before the maximum and is the sum of a part in x_i and one in x_j, it is applied to points,
not to edges, and the maximum is one over the second part alone; what is monotone follows the maximum.

Source: Wang, Sun, Liu, Sarma, Bronstein & Solomon 2019, "Dynamic Graph CNN for Learning on Point Clouds" (ACM TOG 38),
their network for classification, narrower, with a maximum alone over the points.
"""

from collections.abc import Sequence

import torch
from jaxtyping import Float
from torch import Tensor, nn
from torch.nn import functional as F

from lssd_learn.errors import InputError, check_whole
from lssd_learn.nets.dense import dense
from lssd_learn.nets.neighbours import neighbour_graph, neighbours_maximum
from lssd_learn.nets.pooling import pooled_features

SLOPE = 0.2  # of the leaky ReLU below zero

NORMS = ("none", "layer", "batch")


class EdgeConv(nn.Module):
    """One edge convolution: (n, points, inputs) and a graph → (n, points, outputs).

    Args:
        inputs, outputs: features a point.
        norm: what follows the maximum, see `DGCNN`.
    """

    def __init__(self, inputs: int, outputs: int, norm: str):
        super().__init__()
        self.linear = nn.Linear(2 * inputs, outputs)
        self.norm = {"none": nn.Identity, "layer": nn.LayerNorm, "batch": nn.BatchNorm1d}[norm](outputs)

    def forward(self, features: Tensor, graph: Tensor) -> Tensor:
        # W (x_i, x_j − x_i) = (W_point − W_edge) x_i + W_edge x_j
        W_point, W_edge = self.linear.weight.chunk(2, dim=1)
        largest = neighbours_maximum(F.linear(features, W_edge), graph)
        values = F.linear(features, W_point - W_edge, self.linear.bias) + largest
        return F.leaky_relu(self.norm(values.flatten(0, 1)), SLOPE).view_as(values)


class DGCNN(nn.Module):
    """(n, points, channels) clouds → (n, outputs). The order of the points does not matter.

    Args:
        channels: coordinates a point, 3.
        size: points a cloud.
        outputs: numbers to predict.
        neighbours: of a point, itself among them.
        widths: features of each edge convolution.
        embedding: features that are made of all of these together, before the maximum over the points.
        decoder: widths of the hidden layers after it.
        dynamic: find the neighbours anew by the features of each layer; else all layers take those in space.
        norm: "batch", over the points of all clouds of a batch, or of a process's share of it, as in the source (there
            over the edges, before the maximum); "layer", over the features of a point; "none".

    Raises:
        InputError: numbers below 1, no edge convolution, more neighbours than points, an unknown norm.
    """

    reads = "clouds"

    def __init__(
        self,
        channels: int,
        size: int,
        outputs: int,
        neighbours: int = 20,
        widths: Sequence[int] = (32, 32, 64),
        embedding: int = 256,
        decoder: Sequence[int] = (64,),
        dynamic: bool = True,
        norm: str = "batch",
    ):
        super().__init__()
        check_whole("net.neighbours", neighbours, 1, size)
        if norm not in NORMS:
            raise InputError(f"net.norm={norm}: expected one of {', '.join(NORMS)}")
        if not widths:
            raise InputError("net.widths=: expected the width of one edge convolution at least")
        for width in widths:
            check_whole("net.widths", width, 1)
        check_whole("net.embedding", embedding, 1)
        self.neighbours, self.dynamic = neighbours, dynamic
        before = (channels, *widths[:-1])
        self.convolutions = nn.ModuleList(EdgeConv(a, b, norm) for a, b in zip(before, widths, strict=True))
        self.embed = nn.Linear(sum(widths), embedding)
        self.decoder = dense((embedding, *decoder, outputs))

    def forward(self, clouds: Float[Tensor, "n size channels"]) -> Float[Tensor, "n outputs"]:
        graph = neighbour_graph(clouds, self.neighbours)
        features = [clouds]
        for i, convolution in enumerate(self.convolutions):
            if self.dynamic and i:
                graph = neighbour_graph(features[-1].detach(), self.neighbours)
            features.append(convolution(features[-1], graph))
        pooled = pooled_features([self.embed], torch.cat(features[1:], dim=-1))
        return self.decoder(F.leaky_relu(pooled, SLOPE))
