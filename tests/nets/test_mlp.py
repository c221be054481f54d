from functools import partial

import pytest
import torch

from lssd_learn.nets import MLP, reads
from lssd_learn.nets.mlp import PARAMETERS, WIDTHS, first_width


def count(net):
    return sum(p.numel() for p in net.parameters())


@pytest.mark.parametrize("size", WIDTHS)
def test_the_papers_widths_make_it_as_large_as_pointnet(size):
    net = MLP(1, size, 12)
    assert net.layers[0].out_features == WIDTHS[size]
    assert abs(count(net) / PARAMETERS - 1) < 0.01


@pytest.mark.parametrize(("channels", "size"), [(1, 15), (1, 35), (2, 20), (2, 40), (1, 64)])
def test_other_sizes_take_the_nearest_width(channels, size):
    width = first_width(channels, size, 12)
    off = [abs(count(MLP(channels, size, 12, first=w)) - PARAMETERS) for w in (width - 1, width, width + 1)]
    assert off[1] == min(off)


def test_it_is_never_empty():
    assert first_width(2, 500, 12) == 1


def test_shapes():
    net = MLP(2, 6, 5, hidden=(7,))
    assert net(torch.randn(3, 2, 6, 6)).shape == (3, 5)
    assert [layer.out_features for layer in net.layers[::2]] == [first_width(2, 6, 5, (7,)), 7, 5]


def test_final_relu_is_an_option():
    torch.manual_seed(0)
    x = torch.randn(30, 1, 5, 5)
    assert MLP(1, 5, 12, final_relu=True)(x).min() == 0
    assert MLP(1, 5, 12)(x).min() < 0


def test_reads():
    assert reads(partial(MLP, final_relu=True)) == "operators"
